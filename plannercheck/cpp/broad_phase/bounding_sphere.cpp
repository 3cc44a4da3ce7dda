#include "broad_phase/bounding_sphere.hpp"

#include "broad_phase/obstacle_tree.hpp"

namespace plannercheck {
namespace {

// Bodies are off rigid by at most 3.6e-6 (plannercheck/robots/unit_lengths.py), so they stretch by half of that.
constexpr double kPosedStretch = 1 + 4e-6;

// `ball`: around the hull, or a part of it.
BoundingBall on_link(const GeometryObject& object, const SmallBall& ball) {
  const double radius = ball.radius + object.body->inflation_radius;
  const Vec3 centre = object.placement.apply(ball.centre);
  const double reach = norm_1(object.placement.translation()) + 2 * (object.body->origin_radius + radius);
  return {object.link,
          {static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z)},
          rounded_up(radius * kPosedStretch),
          rounded_up(reach * BoundingBall::kCentreError)};
}

}  // namespace

// Each number of the posed centre is at most that of the origin and the length of the ball's own centre, but for less
// than kRoom of it; what is rounded here is 2^-50 of the sum.
float BoundingBall::radius_anywhere(PoseError error) const {
  constexpr double kRoom = 1.01;
  const double size = 3 * kRoom * (double{error.reach} + double{reach()});
  const double sum = (size * kCentreError + double{room} + double{error.of_point(reach())}) + double{radius};
  return rounded_up(sum * (1 + 2 * kCentreError) + 1e-37);
}

BoundingBall bounding_ball(const GeometryObject& object) { return on_link(object, object.body->small_ball()); }

std::vector<BoundingBall> slice_balls(const GeometryObject& object) {
  std::vector<BoundingBall> out;
  const std::vector<SmallBall>& balls = object.body->few_covering_balls();
  for (std::size_t k = 0; k < balls.size() && balls.size() > 1; ++k) out.push_back(on_link(object, balls[k]));
  return out;
}

}  // namespace plannercheck
