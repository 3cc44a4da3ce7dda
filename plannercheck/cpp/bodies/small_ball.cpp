#include "bodies/small_ball.hpp"

#include <cmath>

namespace plannercheck {
namespace {

double radius_around(const std::vector<Vec3>& points, Vec3 centre, Vec3* furthest) {
  double most = -1;
  for (const Vec3& p : points) {
    const double square = dot(p - centre, p - centre);
    if (square > most) most = square, *furthest = p;
  }
  return std::sqrt(most);
}

}  // namespace

// The centre walks towards the furthest point in ever smaller steps (Badoiu and Clarkson's core sets: after n steps the
// radius is within about 1/n of the least).
SmallBall small_ball(const std::vector<Vec3>& points, Vec3 centre) {
  constexpr int kSteps = 128;
  Vec3 furthest;
  SmallBall best{centre, radius_around(points, centre, &furthest)};
  for (int step = 1; step <= kSteps; ++step) {
    centre = centre + (1.0 / (step + 1)) * (furthest - centre);
    const double radius = radius_around(points, centre, &furthest);
    if (radius < best.radius) best = {centre, radius};
  }
  best.radius = best.radius * (1 + 0x1p-48);
  return best;
}

}  // namespace plannercheck
