// The distance of two bodies that share no point, of which one is a solid at least.
//
// In: two posed bodies. Out: the least distance of a triangle of one from a triangle of the other. Idea: pairs of nodes
// are followed down both trees, the nearest first, and left out once their boxes are further apart than two triangles
// that have been found.
#pragma once

#include "narrow_phase/distance.hpp"

namespace plannercheck {

// `limit`: as for pair_distance. `least`: a lower bound that is known; none is below it.
PairDistance solid_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit, double least,
                            PairCounters& counters);

}  // namespace plannercheck
