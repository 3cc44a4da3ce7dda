// Balls and a rounded box inside a body. If a ball in one body overlaps the box in another, or a vertex of one body is
// in that box, the bodies share a point.
//
// In: a body with a polar, or a point or a segment. Out: some balls that together cover much of it, and one rounded
// box, in the body's frame and without the inflation radius; none if the body is as thin as rounding. All lie within
// its hull whatever the rounding, except that a segment's balls have their centres on it only up to rounding. And
// vertices, spread over the body.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

struct Polytope;

inline constexpr std::size_t kInnerBalls = 4;  // of a body at most (measured)

struct InnerBall {
  Vec3 centre;
  double radius;
};

// The points within `radius` of a box along the frame's axes.
struct InnerBox {
  Vec3 low, high;
  double radius;
};

// Balls side by side: x, y, z, radius.
inline constexpr std::size_t kSamples = 8;
struct alignas(64) SampleBlock {
  std::array<std::array<double, kSamples>, 4> entry;
};

struct InnerShapes {
  std::vector<InnerBall> balls;  // the one that covers most first
  std::optional<InnerBox> box;
  std::vector<SampleBlock> samples;  // the balls, and vertices as balls without radius; the last fills what is left
};

InnerShapes find_inner_shapes(const Polytope& body);

}  // namespace plannercheck
