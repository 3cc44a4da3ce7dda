// Convex hulls of points that have no volume: a polygon, a segment or a point, exact.
#pragma once

#include <vector>

#include "bodies/affine_dimension.hpp"
#include "bodies/hierarchy.hpp"
#include "math/vec.hpp"

namespace plannercheck {

struct FlatHull {
  int dimension = 0;           // 0 point, 1 segment, 2 polygon
  std::vector<Vec3> vertices;  // exactly the extreme points; those of a polygon in cyclic order
  std::vector<int> source;     // index into the given points, per vertex
};

// `span`: that of the points, of dimension 0, 1 or 2.
FlatHull flat_hull(const std::vector<Vec3>& points, const AffineSpan& span);

// Levels that drop every other vertex of the polygon. As in space, at most one vertex of the next finer level lies
// beyond a plane tangent to a level, and it is a neighbour of the vertex of tangency.
Hierarchy build_flat_hierarchy(const FlatHull& hull);

}  // namespace plannercheck
