#include "narrow_phase/gjk.hpp"

#include <algorithm>
#include <limits>

#include "narrow_phase/simplex_projection.hpp"

namespace plannercheck {
namespace {

constexpr int kGjkRounds = 64;

// tests/error_bounds/gjk checks these bounds; those of differences and their heights are minkowski_difference.hpp's.
//
// kVolume: determinants of three corners, times the product of their |.|_1: cross product, product and two sums, 5u.
// kMixedAbove: vertices less a centre, mixed: 16u of the radius, and less than as much for their product with a facet.
constexpr double kMixedAbove = 64 * 0x1p-53;
constexpr double kVolume = 16 * 0x1p-53;
constexpr double kInflationAlong = 1 + 4 * 0x1p-53, kNormAbove = 1 + 8 * 0x1p-53;

// The mixture of some vectors: vector(i) with weight[i].
template <class Vector>
Vec3 mixed(int count, const std::array<double, 4>& weight, Vector vector) {
  Vec3 sum;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) sum = sum + weight[i] * vector(i);
  return sum;
}

struct Simplex {
  int count = 0;
  std::array<DifferenceCorner, 4> corner;
  std::array<double, 4> weight;
  Vec3 nearest;  // the mixture of the corners' differences

  Vec3 on_body_a() const {
    return mixed(count, weight, [&](std::size_t i) { return corner[i].body_a; });
  }
};

// The face of a simplex whose point is the nearest so far.
struct NearestFace {
  double square;        // of its distance
  unsigned chosen = 0;  // its corners; none: the simplex is no nearer than it was
  std::array<double, 4> weight;
  Vec3 point;
};

// Takes the face of some corners if the origin's projection is inside of it, and nearer.
template <std::size_t kCount>
bool take_face(const Simplex& simplex, unsigned chosen, NearestFace& best) {
  std::array<const Vec3*, 4> p{};
  unsigned left = chosen;
  for (std::size_t i = 0; i < kCount; ++i, left &= left - 1) {
    p[i] = &simplex.corner[static_cast<std::size_t>(__builtin_ctz(left))].difference;
  }
  SimplexProjection<double, Vec3> face;
  if (!face.run(p, kCount)) return false;
  double sum = 0;
  for (std::size_t i = 0; i < kCount; ++i) sum += face.weight[i];
  if (!std::isfinite(sum)) return false;
  std::array<double, 4> parts{};
  Vec3 v;
  for (std::size_t i = 0; i < kCount; ++i) {
    parts[i] = face.weight[i] / sum;
    v = v + parts[i] * *p[i];
  }
  const double square = kCount == 4 ? 0 : dot(v, v);
  if (!(square < best.square)) return false;
  best = {square, chosen, parts, v};
  return true;
}

bool take_face(const Simplex& simplex, unsigned chosen, NearestFace& best) {
  switch (__builtin_popcount(chosen)) {
    case 1:
      return take_face<1>(simplex, chosen, best);
    case 2:
      return take_face<2>(simplex, chosen, best);
    case 3:
      return take_face<3>(simplex, chosen, best);
    default:
      return take_face<4>(simplex, chosen, best);
  }
}

// Keeps the face, among those with the newest corner, that holds the point nearest to the origin, as far as doubles
// tell: a face's own faces are no nearer than its projection. Whatever face is chosen, its point is a mixture of
// corners. False if it is no nearer than `square`; else its squared distance becomes `square`.
bool reduce_to_nearest_face(Simplex& simplex, double& square) {
  const unsigned newest = 1U << (simplex.count - 1);
  NearestFace best{square, 0, {}, {}};
  std::array<bool, 8> is_passed{};  // by the corners besides the newest
  for (unsigned others = newest; others-- > 0;) {
    if (is_passed[others] || !take_face(simplex, others | newest, best)) continue;
    for (unsigned part = others; part > 0;) is_passed[part = (part - 1) & others] = true;
  }
  if (best.chosen == 0) return false;
  simplex.count = 0;
  for (unsigned left = best.chosen; left != 0; left &= left - 1) {
    simplex.corner[static_cast<std::size_t>(simplex.count++)] =
        simplex.corner[static_cast<std::size_t>(__builtin_ctz(left))];
  }
  simplex.weight = best.weight, simplex.nearest = best.point;
  square = best.square;
  return true;
}

// Whether four differences, each known up to `error`, surely hold the origin strictly inside: all four determinants
// that weigh the corners have a sure sign, the same after the alternation. Let L be the largest |.|_1. If each corner
// errs by e = 0.6 `error`, a determinant is off by (L + e)³ − L³. Up to e = L / 5 that is below 3 error L²; beyond, 3
// error L² exceeds L³, which no determinant exceeds.
bool surely_inside(const Simplex& s, double error) {
  std::array<Vec3, 4> w;
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    w[i] = s.corner[i].difference;
    largest = larger(largest, norm_1(w[i]));
  }
  const double bound = 3 * error * largest * largest * (1 + 1e-6) + kVolume * largest * largest * largest + 1e-300;
  const std::array<double, 4> weights{dot(w[1], cross(w[2], w[3])), -dot(w[0], cross(w[2], w[3])),
                                      dot(w[0], cross(w[1], w[3])), -dot(w[0], cross(w[1], w[2]))};
  const bool positive = std::all_of(weights.begin(), weights.end(), [&](double x) { return x > bound; });
  const bool negative = std::all_of(weights.begin(), weights.end(), [&](double x) { return x < -bound; });
  return positive || negative;
}

class NearestPoints {
 public:
  NearestPoints(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters, bool dents = false)
      : body_a_(body_a),
        body_b_(body_b),
        counters_(counters),
        differences_(body_a, body_b, counters),
        inflation_radius_(body_a.body->inflation_radius + body_b.body->inflation_radius),
        dents_(dents),
        difference_error_(differences_.difference_error()),
        support_error_(differences_.support_error()) {}

  Proximity run(Vec3 direction) {
    Simplex simplex;
    return with_corners(search(direction, simplex), simplex);
  }

  HullDistance distance(Vec3 direction, const VertexPairs& from, const DistanceGoal& goal) {
    Simplex simplex;
    HullDistance out = descend(direction, from, goal, simplex);
    out.start.direction = simplex.count > 0 && simplex.count < 4 ? simplex.nearest : out.direction;
    out.start = with_corners(out.start, simplex);
    return out;
  }

 private:
  const PosedPolytope &body_a_, &body_b_;
  PairCounters& counters_;
  MinkowskiDifference differences_;
  double inflation_radius_;
  bool dents_;
  double difference_error_, support_error_;

  static Proximity with_corners(Proximity out, const Simplex& simplex) {
    out.count = simplex.count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex.count); ++i) {
      out.body_a[i] = simplex.corner[i].vertex_a;
      out.body_b[i] = simplex.corner[i].vertex_b;
    }
    return out;
  }

  // Adds a corner and keeps the nearest face; false if that is no progress: the simplex is as near as doubles tell.
  static bool take(const DifferenceCorner& corner, Simplex& simplex, double& square) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(simplex.count); ++i) {
      if (simplex.corner[i].difference == corner.difference) return false;
    }
    simplex.corner[static_cast<std::size_t>(simplex.count++)] = corner;
    if (reduce_to_nearest_face(simplex, square)) return true;
    --simplex.count;
    return false;
  }

  // Continues past separating planes until both bounds meet or doubles make no more progress.
  HullDistance descend(Vec3 direction, const VertexPairs& from, const DistanceGoal& goal, Simplex& simplex) {
    HullDistance out;
    double square = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < static_cast<std::size_t>(from.count); ++i) {
      take(differences_.corner(from.body_a[i], from.body_b[i]), simplex, square);
    }
    if (simplex.count > 0) direction = simplex.nearest;
    out.direction = direction;
    if (simplex.count > 0 && is_enough(simplex, goal, out)) return out;
    for (int round = 0; round < goal.rounds; ++round) {
      ++counters_.rounds;
      const double length = norm(direction);
      if (!(length > kTrustedLength) || !std::isfinite(length)) return out;
      direction = (1 / length) * direction;
      const DifferenceCorner corner = differences_.lowest_along(direction);
      const double height = dot(direction, corner.difference) - support_error_;
      if (round == 0 || height > out.lower) out.direction = direction;
      out.lower = larger(out.lower, height);
      if (goal.met(out)) return out;
      if (!take(corner, simplex, square)) return out;
      if (is_enough(simplex, goal, out)) return out;
      direction = simplex.nearest;
    }
    return out;
  }

  // Takes the bound of a simplex's nearest point. True if that meets the goal, or if the origin is inside of the
  // simplex, as far as doubles tell.
  bool is_enough(const Simplex& simplex, const DistanceGoal& goal, HullDistance& out) const {
    if (simplex.count == 4) return true;
    out.upper = norm_at_any_scale(simplex.nearest) + 2 * difference_error_;
    out.on_body_a = simplex.on_body_a();
    out.on_body_b = out.on_body_a - simplex.nearest;
    return goal.met(out);
  }

  Proximity search(Vec3 direction, Simplex& simplex) {
    Proximity out;
    double square = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kGjkRounds; ++round) {
      ++counters_.rounds;
      const double length = norm(direction);
      if (!(length > kTrustedLength) || !std::isfinite(length)) return out;
      direction = (1 / length) * direction;
      out.direction = direction;
      const DifferenceCorner corner = differences_.lowest_along(direction);
      const double height = dot(direction, corner.difference);
      if (height > inflation_radius_ * kInflationAlong + support_error_) {
        out.answer = Answer::kSeparated;
        return out;
      }
      if (!take(corner, simplex, square)) return out;
      const Vec3 v = simplex.nearest;
      if (shared(simplex, v, out)) return out;
      if (simplex.count == 4) return out;
      direction = v;
    }
    return out;
  }

  // How far both points that a simplex mixes are from points of their bodies, in m.
  double reach_past_dents(const Simplex& s) const {
    const auto reach = [&](const Polytope& body, std::int32_t DifferenceCorner::* vertex) {
      const Vec3 y = mixed(s.count, s.weight, [&](std::size_t i) {
        return body.inner.points[static_cast<std::size_t>(s.corner[i].*vertex)] - body.centre;
      });
      const double error = kMixedAbove * body.polar_radius * body.radius;
      return (1 - scale_past_dents(body, y, error)) * norm(y) * kDentStretch + kMixedAbove * body.radius;
    };
    return reach(*body_a_.body, &DifferenceCorner::vertex_a) + reach(*body_b_.body, &DifferenceCorner::vertex_b);
  }

  // Mixing four corners errs by 4u more of their size, the sum of weights by 4u: twice kDifference covers both.
  bool shared(const Simplex& simplex, Vec3 v, Proximity& out) const {
    const double length = norm(v) * kNormAbove + 2 * difference_error_;
    const bool within = inflation_radius_ > kTrustedLength && length < inflation_radius_ &&
                        (!dents_ || length + reach_past_dents(simplex) < inflation_radius_);
    if (!within && !(simplex.count == 4 && !dents_ && surely_inside(simplex, difference_error_))) return false;
    out.answer = Answer::kShared;
    const double part = inflation_radius_ > 0 ? body_a_.body->inflation_radius / inflation_radius_ : 0;
    out.point = simplex.on_body_a() - part * v;
    return true;
  }
};

}  // namespace

Proximity nearest_points(const PosedPolytope& body_a, const PosedPolytope& body_b, Vec3 hint, PairCounters& counters,
                         bool dents) {
  return NearestPoints(body_a, body_b, counters, dents).run(norm_1(hint) > 0 ? hint : Vec3{1, 0, 0});
}

HullDistance hull_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, Vec3 hint, const VertexPairs& from,
                           const DistanceGoal& goal, PairCounters& counters) {
  return NearestPoints(body_a, body_b, counters).distance(norm_1(hint) > 0 ? hint : Vec3{1, 0, 0}, from, goal);
}

}  // namespace plannercheck
