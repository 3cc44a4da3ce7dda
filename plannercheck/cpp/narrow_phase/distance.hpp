// The distance of two posed bodies, between proved bounds, with the points where they are nearest.
//
// In: two posed bodies. Out: the distance of the inflated bodies or, where the exact verdict says that they share a
// point, minus their penetration depth. Idea: gjk's descent on the hierarchies continues past the first separating
// plane until the gap along its direction equals the length of the nearest difference; if doubles leave a difference,
// double-double continues from the same vertices. Hulls that overlap are left to penetration_depth.hpp.
#pragma once

#include <functional>
#include <limits>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// The radius of a body's ball about its centre.
inline double extent(const Polytope& body) { return body.radius + body.inflation_radius; }

// Distances are promised up to 1e-9 of max(distance, 1e-3 of the larger body's size): how far apart their bounds may
// be.
inline constexpr double kDistanceError = 2.5e-10, kLeastOfSize = 1e-3;

struct PairDistance {
  bool overlap = false;         // the exact verdict; touching counts
  double lower = 0, upper = 0;  // m, of the distance or, if they overlap, of minus the depth
  Vec3 on_body_a, on_body_b;    // in the world, on the surfaces; if they overlap, the deepest point and where it leaves
  Vec3 direction;               // in the world, from B to A: along which A leaves
  double turn = std::numeric_limits<double>::infinity();  // see HullDepth; of hulls that are apart infinite

  // The distance of bodies apart; of others minus a depth that surely separates them.
  double measured() const { return overlap ? lower : upper; }

  // The least of some, of which none has been found yet.
  static PairDistance nothing_near() { return {false, kNoLimit, kNoLimit, {}, {}, {}}; }
  void take(const PairDistance& found) {
    const double least = smaller(lower, found.lower);
    if (found.upper < upper) *this = found;
    lower = least;
  }
};

// Is shown two convex bodies or parts and their distance; over a half-space, A is always the other body.
struct PartVisitor {
  std::function<void(const PosedPolytope& a, const PosedPolytope& b, const PairDistance& found)> show;
  double room = 0;  // m
};

// `limit`: the search ends once the lower bound exceeds it. If solids overlap, the depth is that of their hulls. If the
// bodies are apart, `visit` is shown the pairs of convex parts (a solid's parts are its triangles) that are measured:
// at least all pairs no further apart than the bodies and its room.
PairDistance pair_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit,
                           PairCounters& counters, const PartVisitor* visit = nullptr);

// The distance of the bodies' hulls. `corners`: where the descent begins, from an earlier distance, or none; becomes
// the corners where it ended. Another beginning may change the last digits, or which of several nearest pairs of points
// is found.
PairDistance convex_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit,
                             PairCounters& counters, VertexPairs* corners = nullptr);

// A lower bound after a few steps; for bodies that overlap, the gap of the balls around them.
double distance_bound(const PosedPolytope& body_a, const PosedPolytope& body_b, int rounds, PairCounters& counters);
double convex_bound(const PosedPolytope& body_a, const PosedPolytope& body_b, int rounds, PairCounters& counters);

// The gap of the balls around two bodies, negative if they meet: a lower bound of the signed distance.
double ball_gap(const PosedPolytope& body_a, const PosedPolytope& body_b);

}  // namespace plannercheck
