// How deep a set of parts and a hull are in each other, between proved bounds.
//
// In: two posed bodies. Out: as pair_distance, with closer bounds where a set of parts and a hull overlap. Idea: what
// separates the set separates each part, so the deepest part gives a lower bound. Along its direction, a translation
// that separates each part that overlaps is an upper bound if the exact verdict finds the moved set apart from the
// hull. If the deepest part leaves last, both are the same: the depth of the set is that of this part.
#pragma once

#include "narrow_phase/distance.hpp"

namespace plannercheck {

// Of any two bodies. All parts that overlap are looked at, which pair_distance does not take the time for.
PairDistance signed_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters);

}  // namespace plannercheck
