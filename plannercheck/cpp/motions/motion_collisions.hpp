// Collisions of a motion's states that balls and boxes inside the bodies prove, a block of states at once.
//
// In: a grid of states, a pair that may collide at some of them. Out: a state at which it surely shares a point,
// whatever the rounding, if one is found. Such a motion can't be proved free: a proof would cover that very state.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/body_bounds.hpp"
#include "broad_phase/poses.hpp"
#include "motions/adaptive_subdivision.hpp"
#include "motions/motion_certifier.hpp"
#include "motions/motion_grid.hpp"

namespace plannercheck {

class MotionCollisions {
 public:
  explicit MotionCollisions(const MotionModel& model);

  // The data of a block of the grid's states; links are rounded when they are first asked for.
  struct Block {
    RoundedPoses links;
    FloatBlock poses;
    BodyBounds::Posed<FloatBlock> bounds;
  };
  struct Workspace {
    std::vector<Block> blocks;  // made when grids first need them
    std::size_t used = 0;
  };

  void begin(const MotionGrid& grid, Workspace& workspace) const;
  // A state of that grid; −1 if no collision is found.
  int colliding_state(const NearPair& near, Workspace& workspace) const;

 private:
  std::size_t links_;
  std::vector<std::array<std::int32_t, 2>> links_of_;  // by pair; −1: the world
  BodyBounds bounds_;
};

}  // namespace plannercheck
