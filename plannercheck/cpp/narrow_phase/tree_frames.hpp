// Boxes of two solids' trees at the solids' poses: which children of a node may meet a box of the other tree, in lanes.
//
// In: two posed solids and how far they reach around their triangles. Out: for each direction an affine map between the
// trees' units, in floats, with a bound of all rounding on the way. A box that is mapped is bounded by the absolute
// values of the map's entries. Six axes are tried, those of both boxes. Whatever is not finite counts as meeting.
#pragma once

#include <array>

#include "bodies/solid.hpp"
#include "math/simd.hpp"
#include "narrow_phase/posed_solid.hpp"

namespace plannercheck {

// From one tree's units to the other's. For a point p of the first tree's units, within `error` in each coordinate, its
// place in the other's is m p + shift.
struct TreeMap {
  std::array<std::array<float, 3>, 3> m, size;  // entries, and their absolute values
  std::array<float, 3> shift, error;

  // Around the image of the box, errors included.
  FloatBox around(const FloatBox& box) const;
};

class TreeFrames {
 public:
  // `reach`: how far from their triangles points of both solids together may be, in the world.
  TreeFrames(const PosedSolid& a, const PosedSolid& b, double reach);

  const TreeMap& a_to_b() const { return a_to_b_; }
  const TreeMap& b_to_a() const { return b_to_a_; }

 private:
  TreeMap a_to_b_, b_to_a_;
};

// Bit k: child k of the node may meet the other tree's box. `to_other`, `from_other`: the maps between the node's tree
// and the other one; `image`: the box in the node's tree, see TreeMap::around.
unsigned children_near(const TriangleNode& node, const TreeMap& to_other, const FloatBox& box, const FloatBox& image);

}  // namespace plannercheck
