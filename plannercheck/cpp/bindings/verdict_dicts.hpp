// Verdicts and counters as Python values.
#pragma once

#include <nanobind/nanobind.h>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

nanobind::dict counters_dict(const PairCounters& counters);

// Keys: shared, stage. If separated: normal (in the world, from b to a), and exact_normal if decided in double-double
// or exactly. If shared: point (in the world) and, if decided exactly, vertices_a, vertices_b, exact_weights: these
// weights mix a point of each body's vertices, and the distance of the two is at most the sum of the inflation radii.
// Exact numbers are pairs (hexadecimal integer, power of two). `first_is_a`: whether A is the caller's first
// body.
nanobind::dict verdict_dict(const PairVerdict& verdict, const PosedPolytope& body_a, const PosedPolytope& body_b,
                            bool first_is_a);

}  // namespace plannercheck
