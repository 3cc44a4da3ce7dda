// Boxes around obstacles in floats, rounded outwards: one by one, or side by side.
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

inline FloatBox rounded_outwards(const Box& box) {
  FloatBox out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.low[i] = rounded_down(box.low[i]), out.high[i] = rounded_up(box.high[i]);
  }
  return out;
}

// One in each lane.
template <FloatVector Numbers>
struct BoxLanes {
  static constexpr std::size_t kCount = sizeof(Numbers) / sizeof(float);

  std::array<Numbers, 3> low{}, high{};
  unsigned present = 0;  // a bit for each lane that holds a box
};

template <FloatVector Numbers>
std::vector<BoxLanes<Numbers>> side_by_side(const std::vector<Box>& boxes) {
  constexpr std::size_t kCount = BoxLanes<Numbers>::kCount;
  std::vector<BoxLanes<Numbers>> out((boxes.size() + kCount - 1) / kCount);
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    BoxLanes<Numbers>& lanes = out[b / kCount];
    const FloatBox box = rounded_outwards(boxes[b]);
    lanes.present |= 1U << b % kCount;
    for (std::size_t i = 0; i < 3; ++i) {
      lanes.low[i][b % kCount] = box.low[i], lanes.high[i][b % kCount] = box.high[i];
    }
  }
  return out;
}

}  // namespace plannercheck
