// Whether the triangles of two solids are further apart than a limit, at one pose or at both ends of an interval.
//
// In: both bodies posed, and the frame in which directions are fixed. Out: whether each pair of triangles, one of each
// body, is further apart than the limit along some direction, the same at all poses. Idea: a descent in both trees
// skips pairs of nodes whose boxes are apart along one of six directions, the axes of both bodies at the first pose.
// The remaining pairs of triangles are tried along their normals, then along the lines between their closest points.
#pragma once

#include "motions/swept_distance.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// `count` poses, 1 or 2. The bodies' inflation radii are not counted: the limit has to include them. Rounding of posed
// points and of products with directions is some fifty u of their coordinates, as in swept_distance.
bool solids_further(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit);

}  // namespace plannercheck
