#include "motions/motion_filters.hpp"

#include <algorithm>
#include <limits>

#include "math/shuffle.hpp"

namespace plannercheck {
namespace {

using Row = std::array<Lanes, kGridRow / kStep>;
using LaneVector = std::array<Lanes, 3>;

// The difference of two centres, given by rows, from a state on.
LaneVector difference(const double* a, const double* b, std::size_t i) {
  LaneVector d;
  for (std::size_t k = 0; k < 3; ++k) d[k] = load_lanes(a + k * kGridRow + i) - load_lanes(b + k * kGridRow + i);
  return d;
}

// A vector of the world seen from a frame, given by its pose.
LaneVector turned_back(const Lanes* m, const LaneVector& v) {
  LaneVector out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = (m[k] * v[0] + m[k + 4] * v[1]) + m[k + 8] * v[2];
  return out;
}

// A direction of a frame, turned into the world.
LaneVector turned(const MotionGrid& grid, std::int32_t frame, std::size_t first, Vec3 d) {
  if (frame < 0) return {broadcast(d.x), broadcast(d.y), broadcast(d.z)};
  LaneVector out;
  const Lanes* const m = grid.link(frame, first);
  for (std::size_t k = 0; k < 3; ++k) out[k] = (m[4 * k] * d.x + m[4 * k + 1] * d.y) + m[4 * k + 2] * d.z;
  return out;
}

// The least product of a direction with the points of a posed box of a body or a link.
template <class Box>
Lanes least_of_box(const Box& box, const Lanes* m, const LaneVector& d) {
  const Vec3 middle = 0.5 * (box.low + box.high), half = 0.5 * (box.high - box.low);
  Lanes sum = (d[0] * m[3] + d[1] * m[7]) + d[2] * m[11];
  for (std::size_t k = 0; k < 3; ++k) {
    const Lanes along = (d[0] * m[k] + d[1] * m[k + 4]) + d[2] * m[k + 8];
    sum = sum + (along * middle[k] - absolute(along) * half[k]);
  }
  return sum;
}

std::array<Lanes, 12> pose_in_lanes(const Pose& pose) {
  std::array<Lanes, 12> m;
  for (std::size_t k = 0; k < 12; ++k) m[k] = broadcast(pose.m[k]);
  return m;
}

// The largest number of each of six vectors, in their order, of all at once by halves.
Floats largest_of_each(const std::array<Floats, 6>& v) {
  const auto of_two = [](Floats a, Floats b) {
    return larger(shuffled<0, 8, 2, 10, 4, 12, 6, 14>(a, b), shuffled<1, 9, 3, 11, 5, 13, 7, 15>(a, b));
  };
  const auto of_four = [](Floats a, Floats b) {
    return larger(shuffled<0, 1, 8, 9, 4, 5, 12, 13>(a, b), shuffled<2, 3, 10, 11, 6, 7, 14, 15>(a, b));
  };
  const Floats last = of_two(v[4], v[5]), a = of_four(of_two(v[0], v[1]), of_two(v[2], v[3])), b = of_four(last, last);
  return larger(shuffled<0, 1, 2, 3, 8, 9, 10, 11>(a, b), shuffled<4, 5, 6, 7, 12, 13, 14, 15>(a, b));
}

// A direction of a frame, of length 1 up to rounding: to a point out of a posed box if it is outside, else from the
// centre.
Vec3 out_of_box(Vec3 point, const Pose& pose, Vec3 low, Vec3 high, Vec3 centre, const FrameTurn& frame) {
  const Vec3 c = pose.rotate_back(point - pose.translation());
  const auto beyond = [](double x, double low, double high) { return x < low ? x - low : x > high ? x - high : 0; };
  Vec3 d{beyond(c.x, low.x, high.x), beyond(c.y, low.y, high.y), beyond(c.z, low.z, high.z)};
  if (norm_1(d) == 0) d = c - centre;
  // Poses may stretch, so the direction's length is taken in the frame, where gaps are compared in metres.
  const Vec3 seen = frame.from_world(pose.rotate(d));
  const double length = norm(seen);
  return length > 0 && std::isfinite(length) ? (1 / length) * seen : Vec3{1, 0, 0};
}

// The error of a path's corners in floats: rounding them, and adding to them, errs by 2^-24 of the numbers each.
constexpr double kCornerRounding = 0x1p-22;

}  // namespace

Floats MotionFilters::box_around_path(std::int32_t index, std::int32_t chain) const {
  const double radius = sphere_radius(body(index)) + bounds_.shift_from_obstacles(chain);
  return box_around_path(grid_.centre(index), radius, bounds_.curvature(chain));
}

Floats MotionFilters::box_around_path(const double* centre, double radius, double curvature) const {
  const double grown = radius + chord_deviation(Deviation{curvature}) + slack_;
  std::array<Floats, 6> corners;
#pragma GCC unroll 3
  for (std::size_t k = 0; k < 3; ++k) {
    // Lanes beyond the last state repeat it.
    const double* row = centre + k * kGridRow;
    Lanes low = load_lanes(row), high = low;
    for (std::size_t i = kStep; i <= grid_.intervals(); i += kStep) {
      low = smaller(low, load_lanes(row + i)), high = larger(high, load_lanes(row + i));
    }
    corners[k] = joined_floats(&high, 0), corners[k + 3] = -joined_floats(&low, 0);
  }
  return largest_of_each(corners) + static_cast<float>((grown + size_ * kCornerRounding) * (1 + kCornerRounding));
}

unsigned MotionFilters::near(const CertifiedPair& pair) const {
  const double apart = sphere_radius(body(pair.a)) + chord_deviation(pair) + slack_;
  if (stands_still(pair.b)) {
    // The error of using the transpose of a placement off rigid as its inverse.
    const double turned = 2 * defects_[at(pair.b)] * size_;
    return chord_meets_box(pair, apart + body(pair.b).inflation_radius * kStretch + turned);
  }
  const double sum = apart + sphere_radius(body(pair.b));
  return spheres_come_near(pair, sum) ? chord_meets_sphere(pair, sum) : 0;
}

// The intervals on which the sphere around a, its centre on the chord, meets b's box; in b's frame.
unsigned MotionFilters::chord_meets_box(const CertifiedPair& pair, double apart) const {
  const Polytope& b = body(pair.b);
  const auto& m = model_.bodies[at(pair.b)].placement.m;
  const double* c = grid_.centre(pair.a);
  const Lanes limit = broadcast(apart * apart);
  unsigned open = 0;
  LaneVector after{};
  for (std::size_t past = past_blocks(); past > 0; past -= kStep) {
    const std::size_t i = past - kStep;
    const Lanes x = load_lanes(c + i) - m[3], y = load_lanes(c + kGridRow + i) - m[7],
                z = load_lanes(c + 2 * kGridRow + i) - m[11];
    Lanes square{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Lanes from = (m[k] * x + m[k + 4] * y) + m[k + 8] * z, to = next_lanes(from, after[k]);
      const Lanes beyond = larger(b.low[k] - larger(from, to), smaller(from, to) - b.high[k]);
      const Lanes outside = larger(Lanes{}, beyond);
      square = square + outside * outside;
      after[k] = from;
    }
    open |= bits_at_most(square, limit) << i;
  }
  return open & all_intervals();
}

// Whether the spheres are near enough at the states to meet between them: the centres approach each other at most at
// the sum of both speeds, seen from the frame.
bool MotionFilters::spheres_come_near(const CertifiedPair& pair, double sum) const {
  Lanes least = broadcast(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i <= grid_.intervals(); i += kStep) {
    const LaneVector d = difference(grid_.centre(pair.a), grid_.centre(pair.b), i);
    least = smaller(least, (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]);
  }
  const double max_distance = sum + speed(pair) * grid_.step() / 2;
  return bits_at_most(least, broadcast(max_distance * max_distance)) != 0;
}

// Let c be the difference of the centres in the middle of a chord and d that of its ends. The distance along the chord
// is at least √(c·c − |c·d|).
unsigned MotionFilters::chord_meets_sphere(const CertifiedPair& pair, double sum) const {
  const Lanes limit = broadcast(sum * sum);
  unsigned open = 0;
  LaneVector after{};
  for (std::size_t past = past_blocks(); past > 0; past -= kStep) {
    const std::size_t i = past - kStep;
    LaneVector d = difference(grid_.centre(pair.a), grid_.centre(pair.b), i);
    if (pair.frame >= 0) d = turned_back(grid_.link(pair.frame, i), d);
    Lanes square{}, along{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Lanes from = d[k], to = next_lanes(from, after[k]);
      const Lanes middle = 0.5 * (from + to);
      square = square + middle * middle;
      along = along + middle * (to - from);
    }
    after = d;
    open |= bits_at_most(square - absolute(along), limit) << i;
  }
  return open & all_intervals();
}

// The height of a chord over a plane is least at one of its ends.
unsigned MotionFilters::near_plane(const CertifiedPair& pair, const WorldPlane& plane) const {
  const double* c = grid_.centre(pair.a);
  const Lanes apart = broadcast(sphere_radius(body(pair.a)) + this->apart(pair));
  unsigned open = 0;
  Lanes after{};
  for (std::size_t past = past_blocks(); past > 0; past -= kStep) {
    const std::size_t i = past - kStep;
    Lanes height = broadcast(-plane.offset);
    for (std::size_t k = 0; k < 3; ++k) {
      height = height + load_lanes(c + k * kGridRow + i) * plane.normal[k];
    }
    open |= bits_at_most(smaller(height, next_lanes(height, after)), apart) << i;
    after = height;
  }
  return open & all_intervals();
}

void MotionFilters::boxes_settle(DirectedPair& found, Vec3 direction, double beyond) {
  const CertifiedPair& p = pair(found.pair);
  const bool still = stands_still(p.b);
  const auto standing = pose_in_lanes(model_.bodies[at(p.b)].placement);
  const Lanes limit = broadcast(apart(p) + beyond);
  Row gaps;
  Lanes after{};
  for (std::size_t past = past_blocks(); past > 0; past -= kStep) {
    const std::size_t i = past - kStep;
    const LaneVector d = turned(grid_, p.frame, i, direction), opposite{-d[0], -d[1], -d[2]};
    const Lanes gap = least_of_box(body(p.a), grid_.poses(p.a, i), d) +
                      least_of_box(body(p.b), still ? standing.data() : grid_.poses(p.b, i), opposite);
    const Lanes least = smaller(gap, next_lanes(gap, after));
    found.open &= ~((bits_above(least, limit) & ((1U << kLanes) - 1)) << i);
    gaps[i / kStep] = after = gap;
  }
  found.depth = std::numeric_limits<double>::infinity();
  for (unsigned states = found.open | found.open << 1; states != 0; states &= states - 1) {
    const auto state = static_cast<std::size_t>(__builtin_ctz(states));
    const double gap = gaps[state / kStep][state % kStep];
    if (gap < found.depth) found.depth = gap, found.state = state;
  }
}

bool MotionFilters::are_apart(const LinkBox& a, const LinkBox& b, std::int32_t frame, Vec3 direction,
                              double limit) const {
  for (std::size_t i = 0; i <= grid_.intervals(); i += kStep) {
    const LaneVector d = turned(grid_, frame, i, direction), opposite{-d[0], -d[1], -d[2]};
    const Lanes gap = least_of_box(a, grid_.link(a.link, i), d) + least_of_box(b, grid_.link(b.link, i), opposite);
    if (bits_above(gap, broadcast(limit)) != (1U << kStep) - 1) return false;
  }
  return true;
}

PosedPair MotionFilters::posed(const CertifiedPair& pair, std::size_t state) {
  return {grid_.pose(pair.a, state), grid_.pose(pair.b, state), grid_.turn(pair.frame, state)};
}

Vec3 MotionFilters::between(const CertifiedPair& pair, std::size_t state) {
  const PosedPair p = posed(pair, state);
  const Polytope &a = body(pair.a), &b = body(pair.b);
  return out_of_box(p.a.apply(a.centre), p.b, b.low, b.high, b.centre, p.frame);
}

Vec3 MotionFilters::between(const LinkBox& a, const LinkBox& b, std::int32_t frame, std::size_t state) const {
  const Vec3 middle = 0.5 * (a.low + a.high);
  return out_of_box(grid_.link_pose(a.link, state).apply(middle), grid_.link_pose(b.link, state), b.low, b.high,
                    0.5 * (b.low + b.high), grid_.turn(frame, state));
}

}  // namespace plannercheck
