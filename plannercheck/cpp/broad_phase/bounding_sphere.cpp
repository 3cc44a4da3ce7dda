#include "broad_phase/bounding_sphere.hpp"

#include "broad_phase/obstacle_tree.hpp"

namespace plannercheck {
namespace {

// Bodies are off rigid by at most 3.6e-6 (plannercheck/robots/unit_lengths.py), so they stretch by half of that.
constexpr double kPosedStretch = 1 + 4e-6;

}  // namespace

BoundingBall bounding_ball(const GeometryObject& object) {
  const SmallBall& ball = object.body->small_ball();
  const double radius = ball.radius + object.body->inflation_radius;
  const Vec3 centre = object.placement.apply(ball.centre);
  const double reach = norm_1(object.placement.translation()) + 2 * (object.body->origin_radius + radius);
  return {object.link,
          {static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z)},
          rounded_up(radius * kPosedStretch),
          rounded_up(reach * BoundingBall::kCentreError)};
}

}  // namespace plannercheck
