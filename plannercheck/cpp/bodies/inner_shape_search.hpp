// Chooses balls and a box inside a body, for any test of the body's inside.
//
// In: a body, and its inside: `radius_around(point)`, the radius of a ball around a point that is inside, not positive
// if none is; and `holds(box)`, for boxes that hold a point inside. Out: balls that were tried, the balls that together
// cover most, and a large box. `radius_around` and `holds` alone prove that they are inside.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "bodies/inner_shapes.hpp"
#include "math/vec.hpp"

namespace plannercheck {

// This many points inside are tried as centres of balls, out of those spread over the body's box (measured: 96 of 256
// settle 2 % fewer collisions, 192 of 1,024 no more).
inline constexpr std::size_t kTriedCentres = 128;
inline constexpr int kSpreadPoints = 512;

// How far a box grows in one step, as parts of the body's edges.
inline constexpr double kFirstStep = 1.0 / 8, kLastStep = 1.0 / 256;
// How round a box may be, in parts of the largest ball's radius. Round boxes fill cylinders and links best.
inline constexpr std::array<double, 2> kRoundings{0, 0.95};

// Spread evenly over a box: multiples, modulo 1, of g^-1, g^-2 and g^-3 with g^4 = g + 1.
inline Vec3 spread_point(Vec3 low, Vec3 high, int k) {
  constexpr std::array<double, 3> kStride{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const auto part = [&](std::size_t i) {
    const double x = 0.5 + (k + 1) * kStride[i];
    return x - std::floor(x);
  };
  const Vec3 edges = high - low;
  return low + Vec3{part(0) * edges.x, part(1) * edges.y, part(2) * edges.z};
}

// Greedily picks the balls that hold most centres not yet covered.
inline std::vector<InnerBall> covering(const std::vector<InnerBall>& balls) {
  std::vector<InnerBall> chosen, left = balls;
  const auto holds = [](const InnerBall& ball, const InnerBall& other) {
    const Vec3 d = other.centre - ball.centre;
    return dot(d, d) < ball.radius * ball.radius;
  };
  while (chosen.size() < kInnerBalls && !left.empty()) {
    const InnerBall* best = nullptr;
    std::ptrdiff_t most = -1;
    for (const InnerBall& ball : balls) {
      const auto held = std::count_if(left.begin(), left.end(), [&](const InnerBall& b) { return holds(ball, b); });
      if (held > most) best = &ball, most = held;
    }
    chosen.push_back(*best);
    if (most == 0) break;
    const auto rest = std::remove_if(left.begin(), left.end(), [&](const InnerBall& b) { return holds(*best, b); });
    left.erase(rest, left.end());
  }
  return chosen;
}

inline Vec3 along_axis(std::size_t axis, double length) {
  return {axis == 0 ? length : 0, axis == 1 ? length : 0, axis == 2 ? length : 0};
}

// Grows the box on all six sides in turn, in ever smaller steps.
template <class Inside>
InnerBox grown(const Inside& inside, Vec3 edges, InnerBox box) {
  const auto grow = [&](std::size_t side, double step) {
    const std::size_t axis = side / 2;
    const Vec3 by = along_axis(axis, step * edges[axis]);
    const InnerBox next =
        side % 2 == 0 ? InnerBox{box.low - by, box.high, box.radius} : InnerBox{box.low, box.high + by, box.radius};
    const bool differs = !(next.low == box.low && next.high == box.high);  // false if rounding swallows the step
    const bool held = differs && inside.holds(next);
    if (held) box = next;
    return held;
  };
  for (double step = kFirstStep; step >= kLastStep; step /= 2) {
    std::array<bool, 6> grows;
    grows.fill(true);
    while (std::find(grows.begin(), grows.end(), true) != grows.end()) {
      for (std::size_t side = 0; side < grows.size(); ++side) grows[side] = grows[side] && grow(side, step);
    }
  }
  return box;
}

inline double volume(const InnerBox& box) {
  const Vec3 d = box.high - box.low;
  const double more = 2 * box.radius;
  return (d.x + more) * (d.y + more) * (d.z + more);
}

// `edges`: of the box around the body.
template <class Inside>
InnerBox largest_box(const Inside& inside, Vec3 edges, const std::vector<InnerBall>& balls) {
  const auto is_smaller = [](const InnerBall& a, const InnerBall& b) { return a.radius < b.radius; };
  const InnerBall ball = *std::max_element(balls.begin(), balls.end(), is_smaller);
  InnerBox best{ball.centre, ball.centre, 0};
  for (const double rounding : kRoundings) {
    const InnerBox box = grown(inside, edges, {ball.centre, ball.centre, rounding * ball.radius});
    if (volume(box) > volume(best)) best = box;
  }
  return best;
}

}  // namespace plannercheck
