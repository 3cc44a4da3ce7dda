// Boxes of two bodies in the states of a block: whether a face's plane of one of them separates both, in lanes.
//
// In: posed links of a block, bodies' boxes in their own frames. Out: the states in which two boxes are apart, whatever
// the rounding. The test of PairFrame::boxes_apart, in floats with more room.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mounted_body.hpp"
#include "simd.hpp"

namespace plannercheck {

// A box in its link's frame, or in the world: columns of `axes` along its edges, of unit length but for rounding.
struct BodyBox {
  std::int32_t link;
  Vec3 centre;
  std::array<Vec3, 3> axes;
  std::array<float, 3> half;  // of its edges, with the body's swell
  bool upright;               // the axes are exactly those of the frame
  float room;                 // what the axes may be off, times the edges, and the rounding of posing
};

BodyBox body_box(const MountedBody& mounted);

class BlockBoxes {
 public:
  BlockBoxes() = default;
  BlockBoxes(std::vector<BodyBox> boxes, std::size_t links) : boxes_(std::move(boxes)), links_(links) {}

  struct Posed {
    std::array<std::array<float, kFloats>, 9> axes;  // of edge j: entries 3 j …
    std::array<std::array<float, kFloats>, 3> centre;
    std::array<float, kFloats> room;
  };

  struct Workspace {
    std::vector<Posed> posed;
    std::vector<std::uint64_t> block_of;  // that a body was posed for last
    std::uint64_t block = 1;
  };
  Workspace new_workspace() const;
  // Before the first test of a block.
  static void begin(Workspace& workspace) { ++workspace.block; }

  // Bit k: in state k the boxes of bodies a and b are apart.
  unsigned apart(const Lanes* links, std::size_t a, std::size_t b, Workspace& workspace) const;

 private:
  std::vector<BodyBox> boxes_;
  std::size_t links_ = 0;

  static void spread(const BodyBox& box, Posed& posed);
  void pose(const Lanes* links, const BodyBox& box, Posed& posed) const;
  const Posed& posed(const Lanes* links, std::size_t body, Workspace& workspace) const;
};

}  // namespace plannercheck
