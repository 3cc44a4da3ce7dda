// A point that two bodies share, as the certificates of plannercheck/bodies give it.
//
// In: two posed bodies that share a point. Out: one such point: between mixtures of the vertices of two hulls, parts or
// triangles, in the ratio of the inflation radii; a vertex of a body inside of a solid; the deepest vertex in a
// half-space. It is computed exactly, and each coordinate is rounded once.
#pragma once

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

// `verdict`: of these bodies, which share a point by their hulls.
ExactAnswer exact_contact(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairVerdict& verdict,
                          PairCounters& counters);

Vec3 shared_point(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters);

}  // namespace plannercheck
