// Where a robot's links are in some states: by them it is decided what had better be tested together
// (mover_groups.hpp).
#pragma once

#include <cstddef>
#include <vector>

namespace plannercheck {

// Of all links, row-major 4x4.
struct SampledPoses {
  std::vector<double> poses;
  std::size_t states = 0;
};

}  // namespace plannercheck
