// Whether the triangles of two solids are further apart than a limit, at one pose or at both ends of an interval.
//
// In: both bodies posed, and the frame in which directions are kept. Out: whether each triangle of one is further than
// the limit from each of the other along a direction of its own, the same at all poses. Idea: pairs of nodes are
// followed down both trees; a pair ends where one of six directions keeps its boxes apart, those of both bodies' axes
// at the first pose. What is left of triangles is tried along their normals, and then along the ways between their
// closest points.
#pragma once

#include "motions/swept_distance.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// `count` poses, 1 or 2. The bodies' inflation radii are not counted: the limit has to include them. Rounding of posed
// points and of products with directions is some fifty u of their coordinates, as in swept_distance.
bool solids_further(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit);

}  // namespace plannercheck
