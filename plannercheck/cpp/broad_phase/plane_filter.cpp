#include "broad_phase/plane_filter.hpp"

#include <cmath>

#include "bodies/half_space.hpp"
#include "broad_phase/obstacle_tree.hpp"

namespace plannercheck {

void PlaneFilter::add(std::int32_t pair, std::size_t ball, const GeometryObject& half_space) {
  const HalfSpace& shape = half_space.body->as<HalfSpace>();
  const WorldPlane plane = world_plane(shape, half_space.placement);
  const double radius = half_space.body->inflation_radius;
  const double size =
      norm_1(half_space.placement.translation()) + 2 * std::fabs(shape.offset) / norm_max(shape.normal) + radius;
  const std::array<float, 3> normal{static_cast<float>(plane.normal.x), static_cast<float>(plane.normal.y),
                                    static_cast<float>(plane.normal.z)};
  rows_.push_back({pair, ball, normal, rounded_up(plane.offset + radius + size * kPlaneError + 1e-37)});
}

}  // namespace plannercheck
