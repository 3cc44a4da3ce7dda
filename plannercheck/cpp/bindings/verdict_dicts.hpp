// Verdicts and counters as Python values.
#pragma once

#include <nanobind/nanobind.h>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

nanobind::dict counters_dict(const PairCounters& counters);

// Keys: shared, stage; separated: normal (in the world, from b to a; exact_normal besides if decided in double-double
// or exactly); shared: point (in the world), and if decided exactly vertices_a, vertices_b, exact_weights: the points
// that these weights mix of both bodies' vertices are no further apart than the sum of the inflation radii. Exact
// numbers are pairs (hexadecimal integer, power of two). `guest_is_a`: whether the guest is the caller's first body.
nanobind::dict verdict_dict(const PairVerdict& verdict, const PosedPolytope& guest, const PosedPolytope& host,
                            bool guest_is_a);

}  // namespace plannercheck
