// The decision in exact arithmetic, for what the filters leave over.
//
// Wolfe's algorithm for the point of conv(P) − conv(R) nearest to the origin, on dyadic numbers: vertices, poses
// and swells are taken as the exact numbers that their doubles are. Every step is exact, so the distance falls
// strictly, no set of vertices comes back, and it ends. Needs no interior point: flat bodies, segments and points are
// decided as well. It begins where a filter gave up: bodies that touch in the vertices found there are decided by
// looking at these alone.
#pragma once

#include <array>

#include "math/dyadic.hpp"
#include "narrow_phase/gjk.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

struct ExactAnswer {
  bool shared = false;
  // Separated: a direction from host to guest; the least direction·(p − r) over the hulls exceeds |direction| times the
  // sum of the swells.
  DyadicVec3 direction;
  // Shared: the points Σ weight (guest vertex) and Σ weight (host vertex) in the world are no further apart than the
  // sum of the swells; weights > 0, not normalised.
  int count = 0;
  std::array<std::int32_t, 4> guest, host;
  std::array<Dyadic, 4> weight;
};

// `start`: an undecided answer of a filter, or just a world direction; any will do. The nearer its vertices are, or the
// better the direction separates, the sooner the answer.
ExactAnswer decide_exactly(const PosedBody& guest, const PosedBody& host, const Proximity& start);

}  // namespace plannercheck
