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

}  // namespace plannercheck
