// Boxes around two bodies in the states of a block: whether a plane along two of their edges separates both, in lanes.
//
// In: posed links of a block, bodies' boxes in their own frames. Out: the states in which two boxes are apart, whatever
// the rounding. This is the test of PairFrame::boxes_apart, in floats and with more room for rounding.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/block_cache.hpp"
#include "broad_phase/float_link_poses.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

// A box in its link's frame, or in the world: the rows of `axes` are unit vectors along its edges, up to rounding.
struct BodyBox {
  std::int32_t link;
  std::array<float, 3> centre;
  std::array<std::array<float, 3>, 3> axes;
  std::array<float, 3> half;  // half the edges, with the body's inflation radius
  bool upright;               // the axes are exactly those of the frame
  float room;                 // for axes that are off rigid, times the edges, and for the rounding of posing
};

BodyBox body_box(const GeometryObject& object);

class BlockBoxes {
 public:
  BlockBoxes() = default;
  explicit BlockBoxes(std::vector<BodyBox> boxes) : boxes_(std::move(boxes)) {}

  template <FloatVector Numbers>
  struct PosedIn {
    std::array<Numbers, 9> axes;  // of edge j: entries 3 j to 3 j + 2
    std::array<Numbers, 3> centre;
    Numbers room;
  };
  typedef PosedIn<StateFloats> Posed;  // in the states of a block
  typedef PosedIn<Floats> PosedState;  // in one state

  struct Workspace {
    BlockCache<Posed> in_block;
    BlockCache<PosedState> in_state;

    void begin() { in_block.begin(), in_state.begin(); }
  };
  Workspace new_workspace() const { return {BlockCache<Posed>(boxes_.size()), BlockCache<PosedState>(boxes_.size())}; }

  // Bit k: in state k a face plane separates the boxes of bodies a and b. `links`: all poses; those of moving boxes are
  // read.
  unsigned apart(FloatLinkPoses& links, std::size_t a, std::size_t b, Workspace& workspace) const;

  // The same for planes along an edge of either box. Together, they are all planes that boxes need.
  unsigned apart_at_edges(FloatLinkPoses& links, std::size_t a, std::size_t b, Workspace& workspace) const;

  // A body's box in the block, posed at the first call.
  const Posed& posed(FloatLinkPoses& links, std::size_t body, Workspace& workspace) const {
    const BodyBox& box = boxes_[body];
    return workspace.in_block.of(body, box.link < 0, [&](Posed& out) { pose(links, box, out); });
  }
  // The same in one state.
  const PosedState& posed_in_state(FloatLinkPoses& links, std::size_t body, Workspace& workspace) const {
    const BodyBox& box = boxes_[body];
    return workspace.in_state.of(body, box.link < 0, [&](PosedState& out) { pose_in_state(links, box, out); });
  }

 private:
  std::vector<BodyBox> boxes_;

  template <FloatVector Numbers>
  static void spread(const BodyBox& box, PosedIn<Numbers>& posed);
  template <FloatVector Numbers>
  static void pose_on(const FloatPoseOf<Numbers>& link, PoseError error, const BodyBox& box, PosedIn<Numbers>& posed);
  [[gnu::noinline]] static void pose(FloatLinkPoses& links, const BodyBox& box, Posed& posed);
  [[gnu::noinline]] static void pose_in_state(FloatLinkPoses& links, const BodyBox& box, PosedState& posed);
};

}  // namespace plannercheck
