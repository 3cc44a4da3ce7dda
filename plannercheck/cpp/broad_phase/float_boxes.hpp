// Boxes around obstacles in floats, rounded outwards: one by one, or eight side by side.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "broad_phase/obstacle_tree.hpp"
#include "math/simd.hpp"

namespace plannercheck {

struct FloatBox {
  std::array<float, 3> low, high;
};

inline FloatBox rounded_outwards(const WorldBox& box) {
  FloatBox out;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    out.low[i] = rounded_down(box.low[axis]), out.high[i] = rounded_up(box.high[axis]);
  }
  return out;
}

struct EightBoxes {
  std::array<Floats, 3> low{}, high{};
  unsigned present = 0;  // a bit for each lane that holds a box
};

inline std::vector<EightBoxes> side_by_side(const std::vector<WorldBox>& boxes) {
  std::vector<EightBoxes> out((boxes.size() + kFloats - 1) / kFloats);
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    EightBoxes& eight = out[b / kFloats];
    const FloatBox box = rounded_outwards(boxes[b]);
    eight.present |= 1U << b % kFloats;
    for (std::size_t i = 0; i < 3; ++i) {
      eight.low[i][b % kFloats] = box.low[i], eight.high[i][b % kFloats] = box.high[i];
    }
  }
  return out;
}

}  // namespace plannercheck
