// Sample poses used to choose the groups of movers (mover_groups.hpp). This header has no lanes, because the bindings
// make the poses; mover_groups.hpp has lanes of floats.
#pragma once

#include <cstddef>
#include <vector>

namespace plannercheck {

// Poses of all links, row-major 4x4.
struct SampledPoses {
  std::vector<double> poses;
  std::size_t states = 0;
};

}  // namespace plannercheck
