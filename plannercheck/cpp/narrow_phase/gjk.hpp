// The point of conv(P) − conv(R) nearest to the origin, in doubles, with certificates of its own (Gilbert, Johnson and
// Keerthi 1988, on the hierarchies' extreme vertices). It needs no interior point, so it serves flat and inflated
// bodies. It is also the second filter, after the game: its bounds involve neither facets nor an inverse pose.
#pragma once

#include <array>
#include <limits>

#include "narrow_phase/minkowski_difference.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// The corners of a simplex: pairs of vertices whose differences are mixed.
struct VertexPairs {
  int count = 0;
  std::array<std::int32_t, 4> body_a{}, body_b{};
};

// Its corners are of the nearest point found, or of a shared point.
struct Proximity : VertexPairs {
  Answer answer = Answer::kUndecided;
  Vec3 direction;      // in the world, from B to A: normal of a separating plane, or the best found
  Vec3 direction_low;  // its low part in double-double; 0 if found in doubles
  Vec3 point;          // in the world: a shared point, if there is one
};

// The distance of two hulls without their inflation radii, in m, between proved bounds.
struct HullDistance {
  double lower = 0, upper = std::numeric_limits<double>::infinity();
  Vec3 direction;             // in the world, from B to A, of length 1 up to rounding: proves the lower bound
  Vec3 on_body_a, on_body_b;  // points in the world that are `upper` apart, up to rounding
  Proximity start;            // the vertices behind them, for the next stage
};

// A distance is known well enough if its bounds are within `relative` of max(lower − inflation radius, least) or beyond
// `limit`.
struct DistanceGoal {
  double relative, inflation_radius, least;
  double limit = std::numeric_limits<double>::infinity();
  int rounds = 64;

  bool met(const HullDistance& found) const {
    return found.lower > limit || found.upper - found.lower <= relative * larger(found.lower - inflation_radius, least);
  }
};

// The bounds that doubles can prove. `from`: corners to begin with, in place of the hint; vertices of both bodies.
HullDistance hull_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, Vec3 hint, const VertexPairs& from,
                           const DistanceGoal& goal, PairCounters& counters);

// `hint`: a world direction to begin with. `dents`: points have to be within the inflation radius past the dents of
// both bodies; hulls that share a point do not count, then.
Proximity nearest_points(const PosedPolytope& body_a, const PosedPolytope& body_b, Vec3 hint, PairCounters& counters,
                         bool dents = false);

}  // namespace plannercheck
