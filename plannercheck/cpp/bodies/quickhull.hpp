// The triangles of a convex hull, exact: no point lies strictly above any of them.
//
// In: points. Out: outward triangles of some of the points, and their neighbours across edges. Corners may lie within a
// facet or an edge of the hull (hull.cpp removes those). Idea: points are added one by one; each waits in the list of a
// face that it sees (as in quickhull; Barber, Dobkin, Huhdanpaa 1996). Visibility is exact, so a point is left out only
// if it lies in the hull of the others. The next point is drawn at random (Clarkson and Shor 1989). Taking the furthest
// point, as in quickhull, needs quadratic time for facets of many points that are coplanar up to rounding (80 s instead
// of 3 s for the polar of a double cone over 100,000 points).
#pragma once

#include <vector>

#include "bodies/hull.hpp"

namespace plannercheck {

struct TriangleSurface {
  std::vector<Triangle> triangles, neighbours;  // as in ConvexMesh
};

// Throws HullError if the points have no volume. Equal points give equal surfaces.
TriangleSurface quickhull(const std::vector<Vec3>& points);

}  // namespace plannercheck
