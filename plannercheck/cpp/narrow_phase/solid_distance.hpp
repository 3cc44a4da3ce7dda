// The distance of two bodies that share no point; at least one body is a solid.
//
// In: two posed bodies. Out: the least distance of a triangle of one from a triangle of the other. Idea: a descent in
// both trees, nearest pair of nodes first, skips pairs whose boxes are further apart than the nearest two triangles so
// far.
#pragma once

#include "narrow_phase/distance.hpp"

namespace plannercheck {

// `limit`, `visit`: as for pair_distance. `least`: a lower bound that is known; none is below it.
PairDistance solid_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit, double least,
                            PairCounters& counters, const PartVisitor* visit = nullptr);

}  // namespace plannercheck
