#include "narrow_phase/points_near_hull.hpp"

#include <algorithm>

#include "math/simd.hpp"
#include "narrow_phase/gjk.hpp"
#include "narrow_phase/intersection.hpp"
#include "narrow_phase/movable_ball.hpp"

namespace plannercheck {
namespace {

// Radii: their sum and product with how far the body's pose is off rigid, roots and squares of what is compared with
// them, fewer than ten operations. Rounding of coordinates is in `error`, which has room for 40u of the reach besides.
constexpr double kReachRounding = 16 * 0x1p-53;
constexpr double kOffRigid = 1.01;  // of the defect: as in pair_frame.cpp, for lengths in the body's frame

constexpr std::size_t kGroups = kMostPoints / kLanes;

// One number for each of eight points.
typedef std::array<Lanes, kGroups> EightNumbers;

double number_at(const EightNumbers& values, int k) {
  return values[static_cast<std::size_t>(k) / kLanes][static_cast<std::size_t>(k) % kLanes];
}

// Bits of all groups' comparisons.
template <class Compare>
unsigned bits_where(Compare compare) {
  unsigned out = 0;
  for (std::size_t g = 0; g < kGroups; ++g) out |= bits(reinterpret_cast<LaneMask>(compare(g))) << (g * kLanes);
  return out;
}

// Numbers of fewer points, and zeros after them.
struct Padded {
  double values[kMostPoints] = {};

  Padded(const double* from, int count) { std::copy(from, from + count, values); }
};

Lanes lane_roots(Lanes values) {
  for (int i = 0; i < kLanes; ++i) values[i] = std::sqrt(values[i]);
  return values;
}

}  // namespace

struct PointsNearHull::LanePoints {
  EightNumbers x, y, z;      // in the body's frame, relative to its centre
  EightNumbers error;        // how far a point may be from where it is said to be, with room for 40u more of the reach
  EightNumbers most, least;  // both radii in m of the body's frame: surely not less, surely not more

  Vec3 point(int k) const { return {number_at(x, k), number_at(y, k), number_at(z, k)}; }
};

struct PointsNearHull::Verdicts {
  unsigned near = 0, open = 0;

  void leave_out(unsigned apart) { open &= ~apart; }
  void take(unsigned is_near) { near |= is_near & open, open &= ~is_near; }
};

PointsNearHull::PointsNearHull(const PosedPolytope& body, const Pose& frame, bool filters)
    : body_(body),
      frame_(frame),
      filters_(filters),
      to_body_({&point_at_origin(), frame}, body),
      error_(to_body_.pose_error() + kTrustedLength),
      error_growth_(to_body_.pose_error_growth()) {
  if (body.body->dimension > 1) return;
  const std::vector<Vec3>& ends = body.body->inner.points;
  segment_from_ = ends.front() - body.body->centre;
  segment_direction_ = ends.back() - ends.front();
}

PointsNearHull::LanePoints PointsNearHull::in_lanes(const double* x, const double* y, const double* z,
                                                    const double* radii) const {
  const std::array<double, 9>& m = to_body_.rotation();
  const Vec3 shift = to_body_.shift();
  const double inflation_radius = body_.body->inflation_radius, off_rigid = kOffRigid * to_body_.defect();
  const double up = (1 + off_rigid) * (1 + kReachRounding), down = (1 - off_rigid) * (1 - kReachRounding);
  LanePoints out;
  for (std::size_t g = 0; g < kGroups; ++g) {
    const std::size_t from = g * kLanes;
    const Lanes px = load_lanes(x + from), py = load_lanes(y + from), pz = load_lanes(z + from);
    out.x[g] = (m[0] * px + m[1] * py) + (m[2] * pz + shift.x);
    out.y[g] = (m[3] * px + m[4] * py) + (m[5] * pz + shift.y);
    out.z[g] = (m[6] * px + m[7] * py) + (m[8] * pz + shift.z);
    out.error[g] = error_ + error_growth_ * ((absolute(px) + absolute(py)) + absolute(pz));
    const Lanes reach = load_lanes(radii + from) + inflation_radius;
    out.most[g] = reach * up, out.least[g] = reach * down;
  }
  return out;
}

PointsNearHull::LanePoints PointsNearHull::given(const double* x, const double* y, const double* z, const double* radii,
                                                 int count) const {
  if (count == kMostPoints) return in_lanes(x, y, z, radii);
  const Padded px(x, count), py(y, count), pz(z, count), reaches(radii, count);
  return in_lanes(px.values, py.values, pz.values, reaches.values);
}

void PointsNearHull::by_ball_and_box(const LanePoints& p, Verdicts& verdicts) const {
  const Polytope& body = *body_.body;
  const Vec3 low = body.low - body.centre, high = body.high - body.centre;
  verdicts.leave_out(bits_where([&](std::size_t g) {
    const Lanes room = (p.most[g] + p.error[g]) + body.radius * (1 + kReachRounding);
    return (p.x[g] * p.x[g] + p.y[g] * p.y[g]) + p.z[g] * p.z[g] > room * room;
  }));
  if (verdicts.open == 0) return;
  verdicts.leave_out(bits_where([&](std::size_t g) {
    const auto beyond = [&](Lanes c, double least, double most) {
      return larger(larger(least - c, c - most), Lanes{});
    };
    const Lanes dx = beyond(p.x[g], low.x, high.x), dy = beyond(p.y[g], low.y, high.y),
                dz = beyond(p.z[g], low.z, high.z);
    const Lanes room = p.most[g] + p.error[g];
    return (dx * dx + dy * dy) + dz * dz > room * room;
  }));
}

// A point of the segment is a witness if it is near. If it is the nearest one, as it is up to rounding, the plane
// through it, perpendicular to the way to the point, keeps both ends away.
void PointsNearHull::by_segment(const LanePoints& p, Verdicts& verdicts) const {
  const Vec3 a = segment_from_, w = segment_direction_;
  const double square = dot(w, w), inverse = square > 0 ? 1 / square : 0;
  EightNumbers towards_a, towards_b, length;
  for (std::size_t g = 0; g < kGroups; ++g) {
    const Lanes dx = p.x[g] - a.x, dy = p.y[g] - a.y, dz = p.z[g] - a.z;
    const Lanes part = ((dx * w.x + dy * w.y) + dz * w.z) * inverse;
    const Lanes t = smaller(larger(part, Lanes{}), broadcast(1));
    const Lanes gx = dx - t * w.x, gy = dy - t * w.y, gz = dz - t * w.z;
    length[g] = lane_roots((gx * gx + gy * gy) + gz * gz);
    towards_a[g] = (gx * dx + gy * dy) + gz * dz;
    towards_b[g] = (gx * (dx - w.x) + gy * (dy - w.y)) + gz * (dz - w.z);
  }
  verdicts.leave_out(bits_where([&](std::size_t g) {
    const Lanes room = length[g] * (p.most[g] + p.error[g]);
    return (length[g] > kTrustedLength) & (smaller(towards_a[g], towards_b[g]) > room);
  }));
  verdicts.take(bits_where([&](std::size_t g) { return length[g] + p.error[g] < p.least[g]; }));
}

// `plane`: a polar point, or 0.
void PointsNearHull::by_plane(Vec3 plane, const LanePoints& p, Verdicts& verdicts) {
  const unsigned before = verdicts.open;
  const double polar_radius = body_.body->polar_radius, length = norm(plane) * (1 + kReachRounding);
  verdicts.leave_out(bits_where([&](std::size_t g) {
    const Lanes value = (plane.x * p.x[g] + plane.y * p.y[g]) + plane.z * p.z[g];
    return value > (1 + polar_radius * p.error[g]) + length * p.most[g];
  }));
  if (verdicts.open != before) beyond_ = plane;
}

// The facet furthest beyond the others along the ray from the centre to a point: it holds the point, or leaves it out,
// and others with it, or the ray's point on it is near.
void PointsNearHull::by_facets(const LanePoints& p, Verdicts& verdicts, PairCounters& counters) {
  by_plane(last_plane_, p, verdicts);
  const Polytope& body = *body_.body;
  for (unsigned left = verdicts.open; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const unsigned bit = 1U << k;
    const Vec3 point = p.point(k);
    ++counters.queries_b;
    const Vec3 q = body.polar.points[at(extreme(body.polar, point, counters.queries))];
    const double error = number_at(p.error, k), value = dot(q, point) + body.polar_radius * error;
    const double beyond = (norm(point) + error) * (1 - 1 / value) * (1 + kReachRounding);
    if (value < 1 || beyond + error < number_at(p.least, k)) {
      verdicts.take(bit);
      continue;
    }
    const unsigned before = verdicts.open;
    by_plane(q, p, verdicts);
    if (verdicts.open != before) last_plane_ = q, left &= verdicts.open | bit;
  }
}

void PointsNearHull::decide(const LanePoints& points, Verdicts& verdicts, PairCounters& counters) {
  by_ball_and_box(points, verdicts);
  if (verdicts.open == 0) return;
  if (body_.body->has_polar()) {
    by_facets(points, verdicts, counters);
  } else if (body_.body->dimension <= 1) {
    by_segment(points, verdicts);
  }
}

bool PointsNearHull::is_near(Vec3 point, double radius, PairCounters& counters) {
  const PosedPolytope body_a{&ball_at(point, radius), frame_};
  if (filters_) {
    const Vec3 towards = body_a.pose.apply(point) - body_.pose.apply(body_.body->centre);
    const Proximity found = nearest_points(body_a, body_, towards, counters);
    if (found.answer == Answer::kSeparated) beyond_ = body_.pose.rotate_back(found.direction);
    if (found.answer != Answer::kUndecided) return found.answer == Answer::kShared;
  }
  return test_pair(body_a, body_, {}, nullptr, counters).shared;
}

unsigned PointsNearHull::maybe_near(const double* x, const double* y, const double* z, const double* radii,
                                    int count) const {
  Verdicts verdicts;
  verdicts.open = (1U << count) - 1;
  if (filters_) by_ball_and_box(given(x, y, z, radii, count), verdicts);
  return verdicts.open;
}

unsigned PointsNearHull::near(const double* x, const double* y, const double* z, const double* radii, int count,
                              PairCounters& counters) {
  Verdicts verdicts;
  verdicts.open = (1U << count) - 1;
  beyond_ = to_body_.point_a({x[0], y[0], z[0]});
  if (filters_) decide(given(x, y, z, radii, count), verdicts, counters);
  for (unsigned left = verdicts.open; left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    if (is_near({x[k], y[k], z[k]}, radii[k], counters)) verdicts.near |= 1U << k;
  }
  return verdicts.near;
}

unsigned points_near_hull(const PosedPolytope& body, const Pose& frame, const double* x, const double* y,
                          const double* z, const double* radii, int count, PairCounters& counters) {
  return PointsNearHull(body, frame).near(x, y, z, radii, count, counters);
}

}  // namespace plannercheck
