// The decision in exact arithmetic, for pairs that the filters leave open.
//
// Wolfe's algorithm for the point of conv(P) − conv(R) nearest to the origin, on dyadic numbers: vertices, poses and
// inflation radii are the exact values of their doubles. Every step is exact, so the distance falls strictly, no set of
// vertices comes back, and the algorithm ends. It needs no interior point: it decides flat bodies, segments and points,
// too. It begins where a filter gave up; bodies that touch in the vertices found there are decided from these alone.
#pragma once

#include <array>

#include "math/dyadic.hpp"
#include "narrow_phase/gjk.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

struct ExactAnswer {
  bool shared = false;
  // If separated: a direction from B to A. Its least product with p − r over the hulls exceeds |direction| times
  // both inflation radii.
  DyadicVec3 direction;
  // If shared: the distance of the points Σ weight (A vertex) and Σ weight (B vertex) in the world is at most
  // the sum of the inflation radii; weights > 0, not normalised.
  int count = 0;
  std::array<std::int32_t, 4> body_a, body_b;
  std::array<Dyadic, 4> weight;
};

// `start`: an undecided answer of a filter, or just a world direction. Any will do; the nearer its vertices are, or the
// better its direction separates, the sooner the answer comes.
ExactAnswer decide_exactly(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start);

}  // namespace plannercheck
