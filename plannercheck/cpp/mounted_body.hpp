// A prepared body where it belongs: on a link of the robot, or in the world.
#pragma once

#include <cstdint>
#include <memory>

#include "body.hpp"
#include "vec.hpp"

namespace plannercheck {

struct MountedBody {
  std::shared_ptr<const Body> body;
  std::int32_t link = -1;  // −1: fixed to the world
  Pose placement;          // on the link, or in the world
};

}  // namespace plannercheck
