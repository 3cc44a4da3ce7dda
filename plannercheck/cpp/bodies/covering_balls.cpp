#include "bodies/covering_balls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "bodies/polytope.hpp"
#include "math/box.hpp"

namespace plannercheck {
namespace {

// A slice is so thick, as a part of the box's second longest side (measured: thinner ones save little).
constexpr double kSliceThickness = 0.6;

// Slices are no thinner than this, m: what is small is held by one ball.
constexpr double kThinnestSlice = 0.04;

// Each ball of a few takes as many tests as a body. So there are at most this many, and one more is taken only if that
// makes the largest one smaller than this part of itself (measured).
constexpr int kMostFewBalls = 3;
constexpr double kFarSmaller = 0.7;

// Where an edge is cut, the point errs by less than this part of the largest coordinates.
constexpr double kCutError = 0x1p-48;

// The hull between two planes across an axis is held by its vertices there and by where the planes cut its edges.
class Slices {
 public:
  Slices(const Polytope& body, int axis) : body_(body), axis_(axis) {}

  // Writes points whose hull is the body's part from `low` to `high`.
  void between(double low, double high, std::vector<Vec3>& points) const {
    points.clear();
    for (const Vec3& p : body_.inner.points) {
      if (p[axis_] >= low && p[axis_] <= high) points.push_back(p);
    }
    for (const Triangle& t : body_.triangles) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const int a = t[corner], b = t[corner == 2 ? 0 : corner + 1];
        if (a < b) cut(body_.inner.points[at(a)], body_.inner.points[at(b)], low, high, points);  // each edge once
      }
    }
    if (body_.dimension == 1) cut(body_.inner.points[0], body_.inner.points[1], low, high, points);
  }

 private:
  const Polytope& body_;
  int axis_;

  void cut(const Vec3& a, const Vec3& b, double low, double high, std::vector<Vec3>& points) const {
    for (const double side : {low, high}) {
      if ((a[axis_] < side) == (b[axis_] < side)) continue;
      const double part = (side - a[axis_]) / (b[axis_] - a[axis_]);
      points.push_back(a + part * (b - a));
    }
  }
};

SmallBall ball_around(const std::vector<Vec3>& points) {
  const Box box = box_around(points);
  return small_ball(points, 0.5 * (box.low + box.high));
}

// The axes of the body's frame, along the longest side of its box first.
std::array<int, 3> axes_by_length(const Polytope& body) {
  const Vec3 size = body.high - body.low;
  std::array<int, 3> axes{0, 1, 2};
  std::sort(axes.begin(), axes.end(), [&](int a, int b) { return size[a] > size[b]; });
  return axes;
}

// Bodies without volume have no triangles here; of them only segments are cut.
bool can_be_cut(const Polytope& body) {
  return (body.dimension == 3 && !body.triangles.empty()) || body.dimension == 1;
}

// A ball around each slice of a body that can be cut.
std::vector<SmallBall> balls_of_slices(const Polytope& body, int axis, double slices) {
  const Slices parts(body, axis);
  const double length = body.high[axis] - body.low[axis];
  const double room = kCutError * (norm_1(body.low) + norm_1(body.high)), from = body.low[axis];
  std::vector<SmallBall> balls;
  std::vector<Vec3> points;
  for (double k = 0; k < slices; ++k) {
    // What is before the first cut or after the last one belongs to the slices there, however they are rounded.
    const double low = k == 0 ? from : from + k / slices * length;
    const double high = k + 1 == slices ? body.high[axis] : from + (k + 1) / slices * length;
    parts.between(low, high, points);
    if (points.empty()) continue;
    SmallBall ball = ball_around(points);
    ball.radius += room;
    balls.push_back(ball);
  }
  return balls;
}

double largest_radius(const std::vector<SmallBall>& balls) {
  double most = 0;
  for (const SmallBall& ball : balls) most = larger(most, ball.radius);
  return most;
}

}  // namespace

std::vector<SmallBall> covering_balls(const Polytope& body) {
  const auto axes = axes_by_length(body);
  const Vec3 size = body.high - body.low;
  const double length = size[axes[0]],
               thickness = larger(kThinnestSlice, kSliceThickness * size[axes[1]] + body.inflation_radius);
  if (!can_be_cut(body) || !(length > thickness)) return {body.small_ball()};
  const double slices = length < thickness * kMostCoveringBalls ? std::ceil(length / thickness) : kMostCoveringBalls;
  return balls_of_slices(body, axes[0], slices);
}

std::vector<SmallBall> few_covering_balls(const Polytope& body) {
  std::vector<SmallBall> balls{body.small_ball()};
  if (!can_be_cut(body) || balls[0].radius + body.inflation_radius < kThinnestSlice) return balls;
  for (int slices = 2; slices <= kMostFewBalls; ++slices) {
    std::vector<SmallBall> smaller_ones = balls_of_slices(body, axes_by_length(body)[0], slices);
    const double before = largest_radius(balls) + body.inflation_radius;
    if (largest_radius(smaller_ones) + body.inflation_radius > kFarSmaller * before) break;
    balls = std::move(smaller_ones);
  }
  return balls;
}

}  // namespace plannercheck
