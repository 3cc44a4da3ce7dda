// Sample poses used to choose the groups of movers (mover_groups.hpp). A header of its own, free of lanes, since the
// bindings make them: mover_groups.hpp has lanes of floats.
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
