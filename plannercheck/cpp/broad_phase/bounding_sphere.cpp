#include "broad_phase/bounding_sphere.hpp"

#include <cmath>
#include <vector>

#include "broad_phase/obstacle_tree.hpp"

namespace plannercheck {
namespace {

// Bodies are off rigid by at most 3.6e-6 (plannercheck/robots/unit_lengths.py), so they stretch by half of that.
constexpr double kPosedStretch = 1 + 4e-6;

struct Ball {
  Vec3 centre;
  double radius;
};

double radius_around(const std::vector<Vec3>& points, Vec3 centre, Vec3* furthest) {
  double most = -1;
  for (const Vec3& p : points) {
    const double square = dot(p - centre, p - centre);
    if (square > most) most = square, *furthest = p;
  }
  return std::sqrt(most);
}

// A ball that holds the points and is nearly as small as possible: its centre walks towards the furthest point in ever
// smaller steps (Badoiu and Clarkson's core sets: after n steps the radius is within about 1/n of the least).
Ball small_ball(const Polytope& body) {
  constexpr int kSteps = 128;
  const std::vector<Vec3>& points = body.inner.points;
  Ball best{0.5 * (body.low + body.high), 0};
  Vec3 furthest;
  best.radius = radius_around(points, best.centre, &furthest);
  Vec3 centre = best.centre;
  for (int step = 1; step <= kSteps; ++step) {
    centre = centre + (1.0 / (step + 1)) * (furthest - centre);
    const double radius = radius_around(points, centre, &furthest);
    if (radius < best.radius) best = {centre, radius};
  }
  best.radius = best.radius * (1 + 0x1p-48) + body.inflation_radius;
  return best;
}

}  // namespace

BoundingBall bounding_ball(const GeometryObject& object) {
  const Ball ball = small_ball(*object.body);
  const Vec3 centre = object.placement.apply(ball.centre);
  const double reach = norm_1(object.placement.translation()) + 2 * (object.body->origin_radius + ball.radius);
  return {object.link,
          {static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z)},
          rounded_up(ball.radius * kPosedStretch),
          rounded_up(reach * BoundingBall::kCentreError)};
}

}  // namespace plannercheck
