// The states of a block in which a ball inside one body overlaps a box inside another, in lanes.
//
// In: posed links of a block, the boxes that box_filter.hpp poses. Out: states in which a pair surely shares a point,
// whatever the rounding; these are most of the states in which it does. For a single state lanes run over balls.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/block_cache.hpp"
#include "broad_phase/box_filter.hpp"
#include "broad_phase/float_link_poses.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/state_block.hpp"

namespace plannercheck {

class BlockOverlaps {
 public:
  BlockOverlaps() = default;
  BlockOverlaps(const std::vector<GeometryObject>& bodies, const std::vector<std::array<std::int32_t, 2>>& pairs);

  // It is surely inside the body if the radius is positive.
  template <FloatVector Numbers>
  struct PosedBall {
    Numbers x, y, z, radius;
  };
  typedef std::array<PosedBall<StateFloats>, kInnerBalls> PosedBalls;  // in the states of a block
  typedef PosedBall<Floats> SideBySide;                                // in one state, a ball a lane

  struct Workspace {
    BlockCache<PosedBalls> in_block;
    BlockCache<SideBySide> in_state;

    void begin() { in_block.begin(), in_state.begin(); }
  };
  Workspace new_workspace() const {
    return {BlockCache<PosedBalls>(balls_.size()), BlockCache<SideBySide>(balls_.size())};
  }

  // Whether the pair surely shares a point in the one state of `links`.
  bool overlap_in_state(FloatLinkPoses& links, std::size_t pair, const BlockBoxes& boxes,
                        BlockBoxes::Workspace& posed_boxes, Workspace& workspace) const;

  // Bit k: in state k the pair surely shares a point. `links`: all poses; those of moving bodies are read.
  unsigned overlap(FloatLinkPoses& links, std::size_t pair, const BlockBoxes& boxes, BlockBoxes::Workspace& posed_boxes,
                   Workspace& workspace) const;

 private:
  struct Ball {
    std::array<float, 3> centre;
    float radius;
  };

  // The balls inside a body that moves, in its link's frame.
  struct Balls {
    std::int32_t link = -1;
    std::size_t count = 0;
    std::array<Ball, kInnerBalls> ball;
    SideBySide side_by_side;  // in the link's frame, a ball a lane; lanes without one hold a radius that nothing meets
    float room = 0;           // for the rounding of posing, besides that of a posed centre
  };

  // The box inside any body, in the body's own frame, relative to the middle of the box around it; rounded by `radius`.
  struct Box {
    bool exists = false;
    std::array<float, 3> low, high;
    float radius = 0;
  };

  // Which body of a pair gives the balls and which the box; −1 if neither can.
  struct Roles {
    std::int32_t balls = -1, box = -1;
  };

  std::vector<Balls> balls_;
  std::vector<Box> boxes_;
  std::vector<Roles> roles_;

  static Balls balls_of(const GeometryObject& object);
  static Box box_of(const Polytope& body);
  static float room_of(const Balls& balls, const FloatLinkPoses& links);
  template <FloatVector Numbers>
  static unsigned meet(const PosedBall<Numbers>& ball, const Box& box, const BlockBoxes::PosedIn<Numbers>& frame);
  [[gnu::noinline]] static void pose(FloatLinkPoses& links, const Balls& balls, PosedBalls& out);
  template <FloatVector Numbers>
  static PosedBall<Numbers> posed(const FloatPoseOf<Numbers>& link, const PosedBall<Numbers>& in_link, float room);
};

}  // namespace plannercheck
