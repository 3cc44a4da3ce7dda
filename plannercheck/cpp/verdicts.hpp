// Verdicts and counters as Python values.
#pragma once

#include <nanobind/nanobind.h>

#include "pair_test.hpp"

namespace plannercheck {

nanobind::dict counters_dict(const PairCounters& counters);

// Keys: shared, stage; separated: normal (in the world, from b to a); shared: point (in the world); decided exactly:
// vertices_a, vertices_b (indices of corners, mixed with `weights` to the shared point). `guest_is_a`: whether the
// guest is the caller's first body.
nanobind::dict verdict_dict(const PairVerdict& verdict, const PosedBody& guest, const PosedBody& host, bool guest_is_a);

}  // namespace plannercheck
