// Many points in the world against a few posed bodies.
//
// In: posed bodies, solids among them, and points with radii, in m. Out: which points are within their radii of some
// body, exactly; or how far each point is from each body. Idea: successive points of a cloud are near each other, so a
// ball around eight points rules them out together; points_near_hull.hpp judges the other points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "narrow_phase/points_near_hull.hpp"

namespace plannercheck {

// `xyz`: n rows. `radii`: n numbers, or the same one for all if `radius_step` is 0.
struct GivenPoints {
  const double* xyz;
  const double* radii;
  std::size_t radius_step, count;
};

// Writes for each point whether some body is within its radius; touching counts.
void points_near_bodies(const std::vector<PosedPolytope>& bodies, const GivenPoints& points, std::uint8_t* near);

// The distances of points from groups of bodies, between proved bounds.
struct PointDistances {
  std::vector<double> upper, lower;  // (points, groups) m; 0 if a point is in a body of the group, infinite if beyond
};

// `group`: the group of each body, ascending. A distance beyond a point's radius counts as infinite.
PointDistances distances_of_points(const std::vector<PosedPolytope>& bodies, const std::vector<std::int32_t>& group,
                                   std::size_t groups, const GivenPoints& points);

}  // namespace plannercheck
