// One of two solids whose trees are descended at once.
//
// In: both posed solids, and how far points of both together may be from their triangles. Out: nodes and their boxes by
// the way they were reached, boxes and corners in the other solid's frame.
#pragma once

#include <array>
#include <cstdint>

#include "bodies/solid.hpp"
#include "narrow_phase/posed_solid.hpp"
#include "narrow_phase/tree_frames.hpp"
#include "narrow_phase/triangle_pair.hpp"

namespace plannercheck {

// A node or a triangle of a tree, and where its box is kept: with its parent; the root's with the tree.
struct Below {
  std::int32_t child, parent;
  std::uint32_t place;  // among the parent's children
  float extent;         // of its box, in its tree's units

  bool is_triangle() const { return child < 0; }
  bool has_box_of(const Below& other) const { return parent == other.parent && place == other.place; }
};

typedef std::array<Below, 2> BelowBoth;

inline constexpr std::int32_t kNoParent = -1;

// One of the two solids, and the way from its frame to the other one's.
struct SolidSide {
  PosedSolid posed;
  RelativePose to_other;
  TreeMap map;   // between the trees' units
  double error;  // of corners in the other one's frame

  SolidSide(const PosedSolid& own, const PosedSolid& other, double reach)
      : posed(own),
        to_other(own.pose, other.pose),
        map(own, other, to_other, reach),
        error(to_other.error(norm_1(own.solid->reach))) {}

  const TriangleTree& tree() const { return posed.solid->tree; }
  const TriangleNode& node(const Below& below) const { return tree().nodes[at(below.child)]; }
  Below root() const { return {0, kNoParent, 0, tree().root.extent()}; }

  OrientedBox box(const Below& below) const {
    return below.parent == kNoParent ? tree().root : tree().nodes[at(below.parent)].box(below.place);
  }

  TriangleCorners in_other(std::int32_t triangle) const {
    const TriangleCorners t = tree().corners(triangle);
    return {to_other.apply(t[0]), to_other.apply(t[1]), to_other.apply(t[2])};
  }
};

// Has lines brought that are soon read, as those of large trees are seldom at hand.
template <class Lines>
void bring(const Lines& lines) {
  constexpr std::size_t kLine = 64;
  const auto* from = reinterpret_cast<const char*>(&lines);
  for (std::size_t k = 0; k < sizeof lines; k += kLine) __builtin_prefetch(from + k);
}

}  // namespace plannercheck
