// The configurations of a block of states, in lanes, for filters that look at them; none where only poses are given.
#pragma once

#include <cstddef>
#include <cstring>

#include "math/simd.hpp"

namespace plannercheck {

struct BlockConfigurations {
  const Lanes* columns = nullptr;  // number c of group g: columns[g * width + c]
  std::size_t width = 0;

  bool are_known() const { return columns != nullptr; }
  double value(std::size_t column, std::size_t state) const {
    double value;  // a lane in memory: reading all of them into a register would take longer
    const std::size_t lane = (state / kLanes * width + column) * kLanes + state % kLanes;
    std::memcpy(&value, reinterpret_cast<const char*>(columns) + lane * sizeof value, sizeof value);
    return value;
  }
};

}  // namespace plannercheck
