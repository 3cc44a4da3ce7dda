// A box in the frame of a pose.
#pragma once

#include "math/vec.hpp"

namespace plannercheck {

struct PosedBox {
  Pose pose;
  Vec3 low, high;
};

}  // namespace plannercheck
