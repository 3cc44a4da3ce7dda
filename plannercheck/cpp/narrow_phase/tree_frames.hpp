// Boxes of two solids' trees at the solids' poses: which children of a node may meet a box of the other tree, in lanes.
//
// In: two posed solids and how far they reach around their triangles. Out: for each direction an affine map between the
// trees' units, in floats, with a bound of all rounding on the way. A box that is mapped is bounded by the absolute
// values of the map's entries. Six axes are tried, those of both boxes; against a triangle, the boxes' axes and the
// triangle's normal. Whatever is not finite counts as meeting.
#pragma once

#include <array>

#include "bodies/solid.hpp"
#include "math/simd.hpp"
#include "narrow_phase/posed_solid.hpp"
#include "narrow_phase/triangle_pair.hpp"

namespace plannercheck {

// From one tree's units to the other's. For a point p of the first tree's units, within `error` in each coordinate, its
// place in the other's is m p + shift.
struct TreeMap {
  std::array<std::array<float, 3>, 3> m, size;  // entries, and their absolute values
  std::array<float, 3> shift, error;

  // Around the image of the box, errors included.
  FloatBox around(const FloatBox& box) const;
};

// The map between the frames of two solids, to the one on whose tree it ends. `reach`: how far from their triangles
// points of both solids together may be, in the world.
TreeMap tree_map(const PosedSolid& from, const PosedSolid& to, const RelativePose& relative, double reach);

// The maps of two solids in both directions.
class TreeFrames {
 public:
  TreeFrames(const PosedSolid& a, const PosedSolid& b, double reach)
      : a_to_b_(tree_map(a, b, {a.pose, b.pose}, reach)), b_to_a_(tree_map(b, a, {b.pose, a.pose}, reach)) {}

  const TreeMap& a_to_b() const { return a_to_b_; }
  const TreeMap& b_to_a() const { return b_to_a_; }

 private:
  TreeMap a_to_b_, b_to_a_;
};

// Which children may meet, and by how much: the largest of the axes' gaps, negative for those, in any unit.
struct NearChildren {
  unsigned bits;
  Floats gap;
};

// Children of the node that may meet a box of the other tree. `to_other`: the map between the node's tree and the other
// one; `image`: the box in the node's tree, see TreeMap::around; `scale`: of lengths in
// the node's units to those in the other tree's.
NearChildren children_near(const TriangleNode& node, const TreeMap& to_other, const FloatBox& box,
                           const FloatBox& image, float scale);

// A triangle in the units of a tree, in floats.
class FloatTriangle {
 public:
  // `corners` are in the tree's frame and err by `error`; `reach` as in tree_map.
  FloatTriangle(const TriangleCorners& corners, double error, const TriangleTree& tree, double reach);

  NearChildren children_near(const TriangleNode& node) const;

 private:
  std::array<float, 3> low_, high_, normal_, size_;
  float level_, room_;  // along the normal
};

}  // namespace plannercheck
