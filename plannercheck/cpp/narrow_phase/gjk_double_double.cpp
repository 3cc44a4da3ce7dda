#include "narrow_phase/gjk_double_double.hpp"

#include <algorithm>
#include <limits>

#include "math/dyadic.hpp"
#include "narrow_phase/simplex_double_double.hpp"
#include "narrow_phase/support_exact_direction.hpp"

namespace plannercheck {
namespace {

constexpr int kDistanceRounds = 256;     // of distances, which have no next stage
constexpr int kDoubleDoubleRounds = 32;  // the start is close to the answer; the exact stage decides the rest

// e = kDoubleDoubleError; lengths are in the unit of the pair, see below. Checked by
// tests/error_bounds/gjk_double_double.
//
// (a) A difference. Per entry, M_P p and M_R r are three products and two sums (3e |p|, 3e |r|: rows are at most
//     1 + 2e-6 long), where p and r are exact differences of two doubles: 5.2e as a vector. The origins' difference is
//     exact or rounded once; two more sums: below 8.2e times the size.
// (b) Support. Turning d into a body's frame errs by 3e an entry, 5.2e |d|, which moves the least product by at most
//     10.4e |d| r. The vertex is extreme exactly along the direction computed. Evaluating d·w errs by 3e |d| |w|, and w
//     errs by (a). In all: below 22e |d| times the size.
// (c) Mixing four corners with weights of sum W errs by e in the products and 3e in the sums, besides (a), and W by 3e:
//     below 16e W times the size.
// (d) Determinants of three corners: (a) three times, as in gjk.cpp, and five operations on products of 1-norms. Each
//     constant leaves room for rounding the bound itself.
constexpr double kDifference = 16 * kDoubleDoubleError, kSupport = 64 * kDoubleDoubleError,
                 kMixing = 64 * kDoubleDoubleError, kDeterminant = 32 * kDoubleDoubleError;
// Squares of distances are compared in doubles. They may tie while the direction is still far off: if it is off by an
// angle, the lower bound loses the angle times the bodies' size, and the distance only its square.
constexpr double kSquareTie = 1 + 0x1p-49;
constexpr double kSquares = 32 * kDoubleDoubleError;  // of squares, their products and differences: ten operations
// The error of heights and lengths rounded to doubles, with norms, quotients and sums of weights in doubles: below 8u.
constexpr double kHeightRounding = 0x1p-49, kLengthRounding = 0x1p-48;

// The unit is a power of two near the pair's size. Vertices, translations and inflation radii are scaled to it first,
// so that nothing of relevance underflows: what is lost lies below 2^-1022 units. 2^kMostScaled is the largest factor
// used, as a larger power may be no double. Where all lengths are denormal, the size is therefore a small number of
// units, but above 2^-75, whose sixth power is still far above underflow.
constexpr int kMostScaled = 1000;
constexpr double kLargestFineSize = 0x1p1000;

DoubleDoubleVec3 scaled(const DoubleDoubleVec3& v, double power_of_two) {
  const auto by = [power_of_two](DoubleDouble x) { return DoubleDouble{x.high * power_of_two, x.low * power_of_two}; };
  return {by(v.x), by(v.y), by(v.z)};
}

double power_of_two_below(double x) { return std::ldexp(1.0, std::ilogb(x)); }

// Scales by a power of two to a largest entry of 1/2 to 1, or less where that power is no double; false if zero or not
// finite.
bool scale_to_one(DoubleDoubleVec3& v) {
  const double largest = norm_max(rounded(v));
  if (!(largest > 0) || !std::isfinite(largest)) return false;
  v = scaled(v, std::ldexp(1.0, std::min(-1 - std::ilogb(largest), kMostScaled)));
  return true;
}

// A point of each body's frame from which its vertices are taken.
struct Origins {
  Vec3 body_a, body_b;
  double radii;            // of balls around both points that hold the bodies' vertices, added up, m
  DoubleDoubleVec3 apart;  // A's − B's in the world, m
};

Origins origins_of_frames(const PosedPolytope& body_a, const PosedPolytope& body_b) {
  const double radii = body_a.body->origin_radius + body_b.body->origin_radius;
  return {{}, {}, radii, difference(body_a.pose.translation(), body_b.pose.translation())};
}

// Vertices, so that lengths are those of the bodies and of the gap between them, wherever their frames are: large
// coordinates cancel before anything is rounded.
Origins origins_at_vertices(const PosedPolytope& body_a, const PosedPolytope& body_b) {
  const Vec3 a = body_a.body->inner.points.front(), b = body_b.body->inner.points.front();
  const DyadicVec3 apart = apply_exactly(body_a.pose, a) - apply_exactly(body_b.pose, b);
  const double radii = 2 * (body_a.body->radius + body_b.body->radius);
  return {a, b, radii, {to_double_double(apart.x), to_double_double(apart.y), to_double_double(apart.z)}};
}

class FineNearestPoints {
 public:
  FineNearestPoints(const PosedPolytope& body_a, const PosedPolytope& body_b, const Origins& origins,
                    PairCounters& counters)
      : body_a_(body_a),
        body_b_(body_b),
        counters_(counters),
        origin_a_(origins.body_a),
        origin_b_(origins.body_b),
        length_(origins.radii +
                (norm_1(rounded(origins.apart)) + (body_a.body->inflation_radius + body_b.body->inflation_radius))) {
    in_range_ = length_ > 0 && length_ < kLargestFineSize;
    if (!in_range_) return;
    to_units_ = std::ldexp(1.0, std::min(-std::ilogb(length_), kMostScaled));
    size_ = length_ * to_units_;
    shift_ = scaled(origins.apart, to_units_);
    inflation_radius_ = two_sum(body_a.body->inflation_radius * to_units_, body_b.body->inflation_radius * to_units_);
  }

  // All bounds are in proportion to it, m.
  double length() const { return length_; }

  Proximity run(const Proximity& start) {
    Proximity out = start;
    out.answer = Answer::kUndecided;
    if (!in_range_) return out;
    DoubleDoubleVec3 towards = widen(norm_1(start.direction) > 0 ? start.direction : Vec3{1, 0, 0});
    double square = std::numeric_limits<double>::infinity();
    load(start);
    if (simplex_.count > 0 && (!keep_nearest(0, towards, square) || is_shared())) return answer(out, towards);
    search(towards, square);
    return answer(out, towards);
  }

  HullDistance distance(HullDistance found, const DistanceGoal& goal) {
    if (!in_range_) return found;
    DoubleDoubleVec3 towards = widen(norm_1(found.start.direction) > 0 ? found.start.direction : Vec3{1, 0, 0});
    double square = std::numeric_limits<double>::infinity();
    load(found.start);
    if (simplex_.count > 0 && keep_nearest(0, towards, square)) measure(found);
    for (int round = 0; round < kDistanceRounds && simplex_.count < 4; ++round) {
      ++counters_.rounds;
      if (!scale_to_one(towards)) break;
      const FineCorner corner = furthest_against(towards);
      raise_lower_bound(found, towards, corner);
      if (goal.met(found) || holds(corner)) break;
      simplex_.corner[static_cast<std::size_t>(simplex_.count++)] = corner;
      if (!keep_nearest(1U << (simplex_.count - 1), towards, square, kSquareTie)) break;
      measure(found);
    }
    return found;
  }

 private:
  const PosedPolytope &body_a_, &body_b_;
  PairCounters& counters_;
  Vec3 origin_a_, origin_b_;
  double length_;
  DoubleDoubleVec3 shift_;
  DoubleDouble inflation_radius_{};
  double to_units_ = 1, size_ = 1;
  bool in_range_ = false;
  FineSimplex simplex_;
  Answer answer_ = Answer::kUndecided;

  // By (b), and rounding to doubles.
  void raise_lower_bound(HullDistance& found, const DoubleDoubleVec3& towards, const FineCorner& corner) const {
    const Vec3 d = rounded(towards);
    const double height = dot(towards, corner.difference).high / norm(d);
    const double lower =
        (height - kHeightRounding * std::fabs(height) - 2 * kSupport * size_) / to_units_ - kDenormalError;
    if (lower > found.lower) found.lower = lower, found.direction = (1 / norm(d)) * d;
  }

  // The upper bound from the weights: by (c), and rounding to doubles.
  void measure(HullDistance& found) const {
    DoubleDoubleVec3 mixture{};
    double whole = 0;
    Vec3 on_body_a, on_body_b;
    const double largest = largest_weight();
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex_.count); ++i) {
      const DoubleDouble w{simplex_.weight[i].high / largest, simplex_.weight[i].low / largest};
      const FineCorner& corner = simplex_.corner[i];
      mixture = mixture + w * corner.difference;
      whole += w.high;
      on_body_a = on_body_a + w.high * body_a_.pose.apply(body_a_.body->inner.points[at(corner.body_a)]);
      on_body_b = on_body_b + w.high * body_b_.pose.apply(body_b_.body->inner.points[at(corner.body_b)]);
    }
    const double length = norm_at_any_scale(rounded(mixture)) / whole;
    const double upper = (length * (1 + kLengthRounding) + kMixing * size_) / to_units_ + kDenormalError;
    if (!(upper < found.upper)) return;
    found.upper = upper;
    found.on_body_a = (1 / whole) * on_body_a, found.on_body_b = (1 / whole) * on_body_b;
  }

  // Asks for corners until one proves the bodies apart, the corners prove that they meet, or there is no progress.
  void search(DoubleDoubleVec3& towards, double& square) {
    for (int round = 0; round < kDoubleDoubleRounds && simplex_.count < 4; ++round) {
      ++counters_.rounds;
      if (!scale_to_one(towards)) return;
      const FineCorner corner = furthest_against(towards);
      if (separates(towards, dot(towards, corner.difference))) {
        answer_ = Answer::kSeparated;
        return;
      }
      if (holds(corner)) return;
      simplex_.corner[static_cast<std::size_t>(simplex_.count++)] = corner;
      if (!keep_nearest(1U << (simplex_.count - 1), towards, square) || is_shared()) return;
    }
  }

  void load(const Proximity& start) {
    simplex_.count = start.count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(start.count); ++i)
      simplex_.corner[i] = corner_at(start.body_a[i], start.body_b[i]);
  }

  bool holds(const FineCorner& corner) const {
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex_.count); ++i) {
      if (simplex_.corner[i].body_a == corner.body_a && simplex_.corner[i].body_b == corner.body_b) return true;
    }
    return false;
  }

  // Reduces the simplex to the nearest face; false if that is no nearer than before, or not by about a factor.
  bool keep_nearest(unsigned needed, DoubleDoubleVec3& towards, double& square, double factor = 1) {
    const FineFace face = nearest_face(simplex_, needed);
    if (!(face.square < square * factor)) return false;
    square = face.square;
    if (face.set + 1 != 1U << 4) towards = face.towards;
    int count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if ((face.set >> i & 1U) != 0) simplex_.corner[static_cast<std::size_t>(count++)] = simplex_.corner[i];
    }
    simplex_.count = count;
    simplex_.weight = face.weight;
    return true;
  }

  FineCorner corner_at(std::int32_t p, std::int32_t r) const {
    return {p, r, (turn(body_a_, p, origin_a_) - turn(body_b_, r, origin_b_)) + shift_};
  }

  // M v of a body's vertex, from an origin, in units.
  DoubleDoubleVec3 turn(const PosedPolytope& posed, std::int32_t vertex, Vec3 origin) const {
    const DoubleDoubleVec3 v =
        scaled(difference(posed.body->inner.points[static_cast<std::size_t>(vertex)], origin), to_units_);
    const auto& m = posed.pose.m;
    const auto row = [&](std::size_t i) {
      return (DoubleDouble{m[i], 0} * v.x + DoubleDouble{m[i + 1], 0} * v.y) + DoubleDouble{m[i + 2], 0} * v.z;
    };
    return {row(0), row(4), row(8)};
  }

  // Mᵀ d
  static DoubleDoubleVec3 turn_back(const Pose& pose, const DoubleDoubleVec3& d) {
    const auto& m = pose.m;
    const auto column = [&](std::size_t j) {
      return (DoubleDouble{m[j], 0} * d.x + DoubleDouble{m[j + 4], 0} * d.y) + DoubleDouble{m[j + 8], 0} * d.z;
    };
    return {column(0), column(1), column(2)};
  }

  FineCorner furthest_against(const DoubleDoubleVec3& d) {
    ++counters_.queries_a, ++counters_.queries_b;
    return corner_at(extreme(body_a_.body->inner, FineDirection(-turn_back(body_a_.pose, d))),
                     extreme(body_b_.body->inner, FineDirection(turn_back(body_b_.pose, d))));
  }

  // Whether the height surely exceeds |d| times the inflation radius, both being known up to (b).
  bool separates(const DoubleDoubleVec3& d, DoubleDouble height) const {
    const DoubleDouble above = height - DoubleDouble{kSupport * size_ * norm_1(rounded(d)), 0};
    if (!positive(above)) return false;
    if (!positive(inflation_radius_)) return true;
    const DoubleDouble square = above * above, least = inflation_radius_ * inflation_radius_ * dot(d, d);
    return (square - least).high > kSquares * square.high;
  }

  bool is_shared() {
    const bool shared =
        positive(inflation_radius_) ? within_inflation_radius() : simplex_.count == 4 && surely_inside();
    if (shared) answer_ = Answer::kShared;
    return shared;
  }

  // Whether the weights' mixture surely lies within the inflation radius of the origin; proved for any positive
  // weights.
  bool within_inflation_radius() const {
    DoubleDoubleVec3 mixture{};
    DoubleDouble whole{};
    const double largest = power_of_two_below(largest_weight());
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex_.count); ++i) {
      const DoubleDouble w{simplex_.weight[i].high / largest, simplex_.weight[i].low / largest};
      mixture = mixture + w * simplex_.corner[i].difference;
      whole = whole + w;
    }
    const DoubleDouble reach = (inflation_radius_ - DoubleDouble{kMixing * size_, 0}) * whole;
    if (!positive(reach)) return false;
    const DoubleDouble square = reach * reach;
    return (square - dot(mixture, mixture)).high > kSquares * square.high;
  }

  double largest_weight() const {
    double largest = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex_.count); ++i)
      largest = larger(largest, simplex_.weight[i].high);
    return largest;
  }

  // Whether the four weights, which are determinants, are surely positive.
  bool surely_inside() const {
    double largest = 0;
    for (const FineCorner& corner : simplex_.corner) largest = larger(largest, norm_1(rounded(corner.difference)));
    const double bound = (3 * kDifference * size_ + kDeterminant * largest) * largest * largest * (1 + 1e-6);
    for (const DoubleDouble& w : simplex_.weight) {
      if (!(w.high > bound)) return false;
    }
    return true;
  }

  Proximity answer(Proximity out, const DoubleDoubleVec3& towards) const {
    out.answer = answer_;
    out.direction = rounded(towards);
    out.direction_low = {towards.x.low, towards.y.low, towards.z.low};
    out.count = simplex_.count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex_.count); ++i) {
      out.body_a[i] = simplex_.corner[i].body_a;
      out.body_b[i] = simplex_.corner[i].body_b;
    }
    if (answer_ == Answer::kShared) out.point = shared_point();
    return out;
  }

  // The point between A's mixture and B's, in proportion to the inflation radii; rounded.
  Vec3 shared_point() const {
    Vec3 on_body_a, apart;
    double whole = 0;
    const double largest = largest_weight();
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex_.count); ++i) {
      const double w = simplex_.weight[i].high / largest;
      const auto vertex = static_cast<std::size_t>(simplex_.corner[i].body_a);
      on_body_a = on_body_a + w * body_a_.pose.apply(body_a_.body->inner.points[vertex]);
      apart = apart + (w / to_units_) * rounded(simplex_.corner[i].difference);
      whole += w;
    }
    const double part =
        positive(inflation_radius_) ? body_a_.body->inflation_radius * to_units_ / inflation_radius_.high : 0;
    return (1 / whole) * (on_body_a - part * apart);
  }
};

}  // namespace

Proximity nearest_points_double_double(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start,
                                       PairCounters& counters) {
  return FineNearestPoints(body_a, body_b, origins_of_frames(body_a, body_b), counters).run(start);
}

HullDistance hull_distance_double_double(const PosedPolytope& body_a, const PosedPolytope& body_b,
                                         const HullDistance& found, const DistanceGoal& goal, PairCounters& counters) {
  FineNearestPoints about_frames(body_a, body_b, origins_of_frames(body_a, body_b), counters);
  const HullDistance out = about_frames.distance(found, goal);
  if (goal.met(out) || !(about_frames.length() < kLargestFineSize)) return out;
  FineNearestPoints about_vertices(body_a, body_b, origins_at_vertices(body_a, body_b), counters);
  return about_vertices.length() < about_frames.length() ? about_vertices.distance(out, goal) : out;
}

}  // namespace plannercheck
