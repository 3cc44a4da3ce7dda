// Which obstacles a sphere may touch: a tree over their axis-aligned boxes in the world, eight children a node.
//
// In: boxes of bodies that never move; then spheres in float32. Out: all boxes that a sphere may touch. A node is
// tested in one pass over eight float lanes. Boxes are rounded outwards and comparisons leave room for their own
// rounding, so no box that the sphere touches is missed; NaN counts as near.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "math/box.hpp"
#include "math/simd.hpp"
#include "math/spatial_partition.hpp"
#include "math/vec.hpp"

namespace plannercheck {

// A ball in the world that holds the body it bounds; its radius includes the rounding of its centre.
struct FloatSphere {
  float x, y, z;
  float limit;  // larger squared distances are proved to exceed the radius; see `far_beyond`
};

// The limit that a squared distance in floats has to exceed, to prove that the distance exceeds a radius. Differences
// err by 2^-24 of themselves, squares and sums by three times as much, products that underflow by 2^-149 each.
template <class Number>
Number far_beyond(Number radius) {
  return radius * radius * (1 + 0x1p-20F) + 1e-40F;
}

// How far coordinates lie outside of intervals, up to the sign; 0 inside; NaN stays NaN.
template <FloatVector Coordinates, class Low, class High>
Coordinates beyond(Coordinates c, Low low, High high) {
  const Coordinates lowest = low - Coordinates{}, highest = high - Coordinates{};
  const Coordinates at_least = c > lowest ? c : lowest;
  return c - (at_least < highest ? at_least : highest);
}

// The next float below a double that is no float.
inline float rounded_down(double value) {
  const auto rounded = static_cast<float>(value);
  return static_cast<double>(rounded) > value ? std::nextafterf(rounded, -std::numeric_limits<float>::infinity())
                                              : rounded;
}
inline float rounded_up(double value) { return -rounded_down(-value); }

class ObstacleTree {
 public:
  explicit ObstacleTree(const std::vector<Box>& boxes);

  // Appends the boxes that the sphere may touch.
  void collect(const FloatSphere& sphere, std::vector<std::int32_t>& found) const;

 private:
  static constexpr std::size_t kMostLevels = 11;  // of a tree over 2^31 boxes
  static constexpr std::int32_t kNothing = std::numeric_limits<std::int32_t>::min();

  struct Node {
    std::array<float, kFloats> low_x, low_y, low_z, high_x, high_y, high_z;
    std::array<std::int32_t, kFloats> child;  // a node, the complement of a box, or kNothing
  };

  std::vector<Node> nodes_;  // the root first

  std::int32_t build(const std::vector<Box>& boxes, const std::vector<Vec3>& centres, IndexRange range);
  static unsigned near_children(const Node& node, const FloatSphere& sphere);
};

}  // namespace plannercheck
