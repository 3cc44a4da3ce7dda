// A few balls that together hold a hull, along its longest side: their volume is far smaller than that of one ball
// around the hull.
//
// In: a hull. Out: balls, in its frame. Idea: the hull is cut into slices across the longest side of its box, and each
// slice is held by a nearly smallest ball.
#pragma once

#include <vector>

#include "bodies/small_ball.hpp"

namespace plannercheck {

struct Polytope;

inline constexpr std::size_t kMostCoveringBalls = 6;

// Balls that hold the hull together, without the inflation radius.
std::vector<SmallBall> covering_balls(const Polytope& body);

// Fewer balls, for filters that look at each ball of each body: two or three if that makes them far smaller, else one.
std::vector<SmallBall> few_covering_balls(const Polytope& body);

}  // namespace plannercheck
