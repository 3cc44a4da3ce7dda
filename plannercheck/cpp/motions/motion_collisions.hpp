// Collisions of a motion's states that balls and boxes inside the bodies prove, a block of states at once.
//
// In: a grid of states, pairs that may collide at some of them. Out: a pair that surely shares a point at a state,
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

  struct Workspace {
    RoundedLinks links;
    BlockBoxes::Workspace boxes;
    BlockOverlaps::Workspace overlaps;
  };
  Workspace new_workspace() const;

  // pair: −1 if no collision is found.
  struct Found {
    std::int32_t pair;
    std::size_t state;
  };
  Found find(const MotionGrid& grid, const std::vector<NearPair>& near, Workspace& workspace) const;

 private:
  std::size_t links_;
  BlockBoxes boxes_;
  BlockOverlaps overlaps_;
};

}  // namespace plannercheck
