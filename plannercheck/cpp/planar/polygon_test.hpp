// Whether two posed convex polygons share a point (paper, section "Algorithm in the plane"): O(log n + log m), exact,
// on ordered vertex arrays without preparation; points, segments and touching included.
#pragma once

#include "planar/polygon_signs.hpp"

namespace plannercheck {

// Polygons are convex, with vertices in the order of the boundary, in either direction. They have at least one vertex;
// several vertices on a line are allowed, repeated vertices are not. Verdicts do not depend on `first`.
bool planar_intersect(const PosedPolygon& a, const PosedPolygon& b, Precision first, PlanarCounters& counters);

}  // namespace plannercheck
