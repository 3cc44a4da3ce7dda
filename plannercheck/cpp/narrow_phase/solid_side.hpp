// One of two solids whose trees are descended at once.
//
// In: both posed solids, and how far points of both together may be from their triangles. Out: nodes and their boxes in
// the order of the descent, boxes and corners in the other solid's frame.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "bodies/solid.hpp"
#include "narrow_phase/posed_solid.hpp"
#include "narrow_phase/tree_frames.hpp"
#include "narrow_phase/triangle_pair.hpp"

namespace plannercheck {

// A node or a triangle of a tree, and where its box is kept: with its parent; the root's with the tree.
struct alignas(16) Below {
  std::int32_t child, parent;
  std::uint32_t place;  // among the parent's children
  float extent;         // of its box, in its tree's units

  bool is_triangle() const { return child < 0; }
  bool has_box_of(const Below& other) const { return parent == other.parent && place == other.place; }
};

typedef std::array<Below, 2> BelowBoth;

inline constexpr std::int32_t kNoParent = -1;

// The children of a node as `Below`, each made in a register: a read after narrower writes would wait for them.
class ChildrenBelow {
 public:
  ChildrenBelow(const TriangleNode& node, std::int32_t index) {
    const bool is_leaf = node.leaf >= 0;
    first_ = Entries{is_leaf ? ~node.first : node.first, index, 0, 0};
    step_ = Entries{is_leaf ? -1 : 1, 0, 1, 0};
    const Floats extent =
        (load_floats(node.half[0].data()) + load_floats(node.half[1].data())) + load_floats(node.half[2].data());
    std::memcpy(extent_.data(), &extent, sizeof extent);
  }

  bool are_nodes() const { return step_[0] > 0; }

  Below operator[](unsigned k) const {
    Entries entries = first_ + step_ * static_cast<std::int32_t>(k);
    entries[3] = extent_[k];
    Below out;
    std::memcpy(&out, &entries, sizeof out);
    return out;
  }

 private:
  typedef std::int32_t Entries __attribute__((vector_size(16)));

  Entries first_, step_;
  std::array<std::int32_t, kTreeWidth> extent_;  // bits of floats
};

// Differences are rounded; where a middle is rounded by more than this part of the spread, `error` is so large that no
// volume is trusted (are_volumes_trusted).
inline constexpr double kSpreadRoundedUp = 1 + 0x1p-20;

// One of the two solids, and the way from its frame to the other one's.
struct SolidSide {
  PosedSolid posed;
  RelativePose to_other;
  TreeMap map;    // between the trees' units
  double error;   // of corners in the other one's frame
  double metres;  // of the tree's unit

  SolidSide(const PosedSolid& own, const PosedSolid& other, double reach)
      : posed(own),
        to_other(own.pose, other.pose),
        map(own, other, to_other, reach),
        error(to_other.error(norm_1(own.solid->reach))),
        metres(1 / own.solid->tree.units) {}

  const TriangleTree& tree() const { return posed.solid->tree; }
  const TriangleNode& node(const Below& below) const { return tree().nodes[at(below.child)]; }
  Below root() const { return {0, kNoParent, 0, tree().root.extent()}; }

  OrientedBox box(const Below& below) const {
    return below.parent == kNoParent ? tree().root : tree().nodes[at(below.parent)].box(below.place);
  }

  // A triangle, or a leaf.
  bool is_end(const Below& below) const { return below.is_triangle() || node(below).leaf >= 0; }

  // By how much coordinates of a leaf's corners and of other ones differ at most, in m.
  double spread(const TriangleNode& leaf, const TriangleCorners& others) const {
    double most = static_cast<double>(leaf.reach) * metres;
    for (int axis = 0; axis < 3; ++axis) {
      const double middle =
          tree().middle[axis] + metres * static_cast<double>(leaf.middle[static_cast<std::size_t>(axis)]);
      for (const Vec3& corner : others) most = larger(most, std::fabs(corner[axis] - middle));
    }
    return 2 * kSpreadRoundedUp * most;
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
