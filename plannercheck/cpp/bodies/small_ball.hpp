// A ball that holds a hull and is nearly as small as possible.
#pragma once

#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

struct SmallBall {
  Vec3 centre;
  double radius;  // rounded up
};

// `centre`: where the search begins.
SmallBall small_ball(const std::vector<Vec3>& points, Vec3 centre);

}  // namespace plannercheck
