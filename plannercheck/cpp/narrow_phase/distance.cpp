#include "narrow_phase/distance.hpp"

#include <optional>

#include "narrow_phase/penetration_depth.hpp"

namespace plannercheck {
namespace {

// Bodies are off rigid by at most 3.6e-6, so they stretch by half of that. kBallRounding: the rounding of a ball's
// centre and of distances, relative to their operands. A norm whose squares underflow errs by less than kTrustedLength.
constexpr double kDistanceStretch = 1 + 4e-6, kBallRounding = 64 * 0x1p-53;
// Two inflation radii added, and their sum added to a depth or taken off a distance: 2u of all.
constexpr double kRadiusRounding = 4 * 0x1p-53;

// The limit of doubles, as a part of the larger body's size, and of the distance.
constexpr double kDoublesError = 0x1p-48;

double total_inflation_radius(const PosedPolytope& a, const PosedPolytope& b) {
  return a.body->inflation_radius + b.body->inflation_radius;
}

Vec3 posed_centre(const PosedPolytope& posed) { return posed.pose.apply(posed.body->centre); }

// The distance of bodies whose hulls share a point. `hulls`: the descent towards that point. Its upper bound of the
// distance is used if the depth has no proved lower bound: as far as doubles tell, the hulls then touch or are less
// than this bound apart.
PairDistance hulls_overlap(const PosedPolytope& body_a, const PosedPolytope& body_b, const HullDistance& hulls,
                           const HullDepth& depth) {
  const double inflation_radius = total_inflation_radius(body_a, body_b);
  const double most = (depth.upper + inflation_radius) * (1 + kRadiusRounding);
  const double hulls_least = depth.lower > 0 ? depth.lower : -hulls.upper;
  const double least = hulls_least + inflation_radius * (1 - kRadiusRounding);
  const Vec3 point = depth.on_body_a - body_a.body->inflation_radius * depth.direction;
  return {true,
          -most,
          smaller(-least * (1 - kRadiusRounding), 0),
          point,
          point + most * depth.direction,
          depth.direction,
          depth.turn};
}

PairDistance between_hulls(const PosedPolytope& body_a, const PosedPolytope& body_b, const HullDistance& found,
                           bool overlap) {
  const double inflation_radius = total_inflation_radius(body_a, body_b);
  // Rounds each bound by itself: past a limit there is no upper bound.
  const auto rounding = [&](double bound) {
    return inflation_radius > 0 ? kRadiusRounding * (inflation_radius + bound) : 0;
  };
  PairDistance out{overlap,
                   found.lower - inflation_radius - rounding(found.lower),
                   found.upper - inflation_radius + rounding(found.upper),
                   found.on_body_a,
                   found.on_body_b,
                   found.direction};
  if (overlap) {
    out.lower = smaller(out.lower, 0), out.upper = smaller(out.upper, 0);
  } else {
    // The exact verdict says that there is a gap, however small.
    out.upper = larger(out.upper, std::numeric_limits<double>::denorm_min());
    out.lower = larger(out.lower, 0);
  }
  const Vec3 apart = found.on_body_a - found.on_body_b;
  const Vec3 d = norm_max(apart) > 0 ? unit(apart) : found.direction;
  out.on_body_a = out.on_body_a - body_a.body->inflation_radius * d;
  out.on_body_b = out.on_body_b + body_b.body->inflation_radius * d;
  return out;
}

bool share_a_point(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters) {
  const bool swapped = choose_b(*body_a.body, *body_b.body) == 0;
  PairOptions of_hulls;
  of_hulls.dents = false;
  return test_pair(swapped ? body_b : body_a, swapped ? body_a : body_b, of_hulls, nullptr, counters).shared;
}

DistanceGoal goal_for(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit) {
  const double inflation_radius = total_inflation_radius(body_a, body_b);
  const double size = larger(extent(*body_a.body), extent(*body_b.body));
  return {kDistanceError, inflation_radius, kLeastOfSize * size, limit + inflation_radius};
}

}  // namespace

double ball_gap(const PosedPolytope& body_a, const PosedPolytope& body_b) {
  const Vec3 a = posed_centre(body_a), b = posed_centre(body_b);
  const double radii =
      (body_a.body->radius + body_b.body->radius) * kDistanceStretch + total_inflation_radius(body_a, body_b);
  const double reach = body_a.body->origin_radius + body_b.body->origin_radius + norm_1(a) + norm_1(b) + radii;
  return norm(a - b) - radii - (kBallRounding * reach + kTrustedLength);
}

double convex_bound(const PosedPolytope& body_a, const PosedPolytope& body_b, int rounds, PairCounters& counters) {
  DistanceGoal goal = goal_for(body_a, body_b, std::numeric_limits<double>::infinity());
  goal.rounds = rounds;
  const Vec3 hint = posed_centre(body_a) - posed_centre(body_b);
  const HullDistance found = hull_distance(body_a, body_b, hint, {}, goal, counters);
  const double balls = ball_gap(body_a, body_b);
  return found.lower > 0 ? larger(balls, found.lower - goal.inflation_radius * (1 + 0x1p-50)) : balls;
}

PairDistance convex_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit,
                             PairCounters& counters, VertexPairs* corners) {
  const DistanceGoal goal = goal_for(body_a, body_b, limit);
  DistanceGoal of_doubles = goal;  // the last rounds are cheap, and then nearest points lie on the nearest features
  of_doubles.relative = kDoublesError;
  const Vec3 hint = posed_centre(body_a) - posed_centre(body_b);
  HullDistance found =
      hull_distance(body_a, body_b, hint, corners == nullptr ? VertexPairs{} : *corners, of_doubles, counters);
  if (corners != nullptr) *corners = found.start;
  std::optional<HullDepth> depth;
  bool overlap = false;
  if (!(found.lower > goal.inflation_radius * (1 + 0x1p-48))) {
    if (found.start.count == 4) {  // the hulls share a point, as far as doubles tell: their depth proves it
      depth = hull_depth(body_a, body_b, found.start, counters);
      if (depth->lower > 0) return hulls_overlap(body_a, body_b, found, *depth);
    }
    overlap = share_a_point(body_a, body_b, counters);
  }
  // For hulls that touch, a shared point matters only with inflation radii: these are then the bodies' depth.
  const bool known = overlap && found.start.count == 4 && goal.inflation_radius == 0;
  const bool in_doubt = !goal.met(found) && !known;
  if (in_doubt) found = hull_distance_double_double(body_a, body_b, found, goal, counters);
  if (!(found.lower > 0)) {
    if (!depth) depth = hull_depth(body_a, body_b, found.start, counters);
    if (overlap) return hulls_overlap(body_a, body_b, found, *depth);
    found.direction = depth->direction;  // the descent has none for gaps below its rounding
  }
  return between_hulls(body_a, body_b, found, overlap);
}

}  // namespace plannercheck
