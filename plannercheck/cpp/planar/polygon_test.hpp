// Whether two posed convex polygons share a point (paper, section "Algorithm in the plane"): O(log n + log m) on
// ordered vertex arrays as they are, with no preparation; points, segments and touching included; exact.
#pragma once

#include "planar/polygon_signs.hpp"

namespace plannercheck {

// Polygons are convex, with vertices in the order of the boundary, either way round; runs of vertices on a line are
// allowed, repeated vertices are not. At least one vertex each. Verdicts do not depend on `first`.
bool planar_intersect(const PosedPolygon& a, const PosedPolygon& b, Precision first, PlanarCounters& counters);

}  // namespace plannercheck
