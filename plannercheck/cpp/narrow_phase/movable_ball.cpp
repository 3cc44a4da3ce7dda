#include "narrow_phase/movable_ball.hpp"

#include <vector>

namespace plannercheck {
namespace {

Polytope prepared_point() { return prepare_polytope(std::vector<Vec3>{Vec3{}}); }

Polytope& moved_to(Vec3 point, double radius) {
  thread_local Polytope ball = prepared_point();
  ball.inner.points.front() = point;
  for (VertexBlock& block : ball.inner.top_cursors) block.x.fill(point.x), block.y.fill(point.y), block.z.fill(point.z);
  ball.inner.largest_coordinate = norm_max(point);
  ball.centre = ball.low = ball.high = point;
  ball.origin_radius = norm_above(point);
  ball.inflation_radius = radius;
  return ball;
}

}  // namespace

const Polytope& ball_at(Vec3 point, double radius) { return moved_to(point, radius); }

const Polytope& ball_with_surface_at(Vec3 point, double radius) {
  Polytope& ball = moved_to(point, radius);
  ball.lazy_surface = {};
  return ball;
}

const Polytope& point_at_origin() {
  static const Polytope point = prepared_point();
  return point;
}

}  // namespace plannercheck
