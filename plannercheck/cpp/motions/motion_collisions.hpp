// Collisions of a motion's states that balls and boxes inside the bodies prove, a block of states at once.
//
// In: a grid of states, a pair that may collide at some of them. Out: a state at which it surely shares a point,
// whatever the rounding, if one is found. Such a motion can't be proved free: a proof would cover that very state.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/box_filter.hpp"
#include "broad_phase/float_link_poses.hpp"
#include "broad_phase/overlap_filter.hpp"
#include "motions/adaptive_subdivision.hpp"
#include "motions/motion_certifier.hpp"
#include "motions/motion_grid.hpp"

namespace plannercheck {

class MotionCollisions {
 public:
  explicit MotionCollisions(const MotionModel& model);

  // Of a block of the grid's states.
  struct Block {
    FloatLinkPoses links;
    BlockBoxes::Workspace boxes;
    BlockOverlaps::Workspace overlaps;
  };
  struct Workspace {
    std::vector<Block> blocks;  // made when grids first need them
    std::size_t used = 0;
  };

  void begin(const MotionGrid& grid, Workspace& workspace) const;
  // On that grid; −1 if no collision is found.
  int colliding_state(const NearPair& near, Workspace& workspace) const;

 private:
  std::size_t links_;
  BlockBoxes boxes_;
  BlockOverlaps overlaps_;
};

}  // namespace plannercheck
