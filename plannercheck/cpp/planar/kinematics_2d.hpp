// Poses of a planar chain's links, a configuration in each lane; the same bits on every instruction set.
#pragma once

#include <vector>

#include "math/simd.hpp"
#include "planar/checker_2d.hpp"

namespace plannercheck {

struct PlanarLinkLanes {
  Lanes angle, cos, sin, x, y;
};

// columns: one for each number of a configuration.
void pose_planar_links(const std::vector<PlanarLink>& links, const std::vector<Lanes>& columns,
                       std::vector<PlanarLinkLanes>& out);

}  // namespace plannercheck
