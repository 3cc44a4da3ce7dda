// Boxes of a node's children in lanes.
//
// In: a node of a tree of triangles. Out: middles, half extents and axes, a lane for each child; and half extents of
// the boxes around them along the tree's axes.
#pragma once

#include <array>
#include <cstring>

#include "bodies/triangle_tree.hpp"
#include "math/simd.hpp"

namespace plannercheck {

static_assert(kTreeWidth == kFloats);

struct LaneBoxes {
  std::array<Floats, 3> centre, half;
  std::array<std::array<Floats, 3>, 3> axis;
};

inline LaneBoxes lane_boxes(const TriangleNode& node) {
  typedef std::int16_t Shorts __attribute__((vector_size(2 * kFloats)));
  LaneBoxes out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.centre[i] = load_floats(node.centre[i].data()), out.half[i] = load_floats(node.half[i].data());
    for (std::size_t j = 0; j < 2; ++j) {
      Shorts entries;
      std::memcpy(&entries, node.axis[j][i].data(), sizeof entries);
      out.axis[j][i] = __builtin_convertvector(entries, Floats) * kShortUnit;
    }
  }
  out.axis[2] = third_axis(out.axis[0], out.axis[1]);
  return out;
}

inline std::array<Floats, 3> aligned_half(const LaneBoxes& boxes) {
  std::array<Floats, 3> out;
  for (std::size_t i = 0; i < 3; ++i) {
    Floats sum{};
    for (std::size_t j = 0; j < 3; ++j) sum += absolute(boxes.axis[j][i]) * boxes.half[j];
    out[i] = sum * kAroundRoundedUp;
  }
  return out;
}

// Children that the ray upwards from a point, in the tree's units, may meet.
inline unsigned children_on_ray(const TriangleNode& node, const std::array<float, 3>& from, float room) {
  const LaneBoxes boxes = lane_boxes(node);
  const std::array<Floats, 3> half = aligned_half(boxes);
  const auto way = [&](std::size_t axis) { return boxes.centre[axis] - from[axis]; };
  const auto reach = [&](std::size_t axis) { return half[axis] + room; };
  const FloatMask misses = (absolute(way(0)) > reach(0)) | (absolute(way(1)) > reach(1)) | (way(2) < -reach(2));
  return ~bits(misses) & node.all();
}

// Children whose boxes are within a reach of a place along each axis of the tree, in its units.
inline unsigned children_within(const TriangleNode& node, const std::array<float, 3>& place,
                                const std::array<float, 3>& reach) {
  const LaneBoxes boxes = lane_boxes(node);
  const std::array<Floats, 3> around = aligned_half(boxes);
  FloatMask misses{};
  for (std::size_t i = 0; i < 3; ++i) misses |= absolute(boxes.centre[i] - place[i]) > around[i] + reach[i];
  return ~bits(misses) & node.all();
}

// Hands over the places of triangles that are near, as are the nodes above them, until one is taken; whether one was.
// `near`: of a node's children, a bit each.
template <class Near, class Take>
bool any_triangle(const TriangleTree& tree, Near near, Take take) {
  std::array<std::int32_t, kTreeWidth * TriangleTree::kMostLevels> waiting;
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const TriangleNode& node = tree.nodes[at(waiting[--count])];
    for (unsigned left = near(node); left != 0; left &= left - 1) {
      const std::int32_t child = node.child(static_cast<std::size_t>(__builtin_ctz(left)));
      if (child >= 0) {
        waiting[count++] = child;
      } else if (take(~child)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace plannercheck
