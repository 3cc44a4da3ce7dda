// Boxes around the triangles of a mesh: a tree with eight children a node, in floats that fit one register.
//
// In: points and triangles. Out: triangles in the order of the leaves, and nodes whose boxes hold what is below them.
// Boxes are oriented (oriented_box.hpp), in units in which the mesh extends from −1 to 1 about its middle. They are
// rounded outwards: a point outside of a box, by more than the rounding of its coordinates, is on no triangle below it.
// The children of a node are all nodes, or all triangles, whose corners then lie side by side in lanes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bodies/oriented_box.hpp"
#include "math/vec.hpp"

namespace plannercheck {

using MeshTriangle = std::array<std::int32_t, 3>;

inline constexpr std::size_t kTreeWidth = 8;

// A node, or the complement of a triangle's place.
struct BoxedNode {
  std::int32_t child;
  OrientedBox box;

  bool is_triangle() const { return child < 0; }
};

// Nodes and leaves begin at cache lines.
struct alignas(64) TriangleNode {
  // By axis, then by child; lanes without a child hold zeros.
  std::array<std::array<float, kTreeWidth>, 3> centre{}, half{};
  // By axis of the box, then by entry, then by child, as in ShortAxes.
  std::array<std::array<std::array<std::int16_t, kTreeWidth>, 3>, 2> axis{};
  std::int32_t first = 0;  // child: a node or a triangle; the others follow it
  std::int32_t leaf = -1;  // its triangles' place among the tree's leaves; −1: nodes
  std::uint32_t children = 0;
  // For a leaf: all corners are within `reach` of this point in each coordinate, in the tree's units.
  std::array<float, 3> middle{};
  float reach = 0;

  // Child k: a node, or the complement of a triangle's place.
  std::int32_t child(std::size_t k) const {
    const std::int32_t index = first + static_cast<std::int32_t>(k);
    return leaf >= 0 ? ~index : index;
  }
  // A bit for each child.
  unsigned all() const { return (1U << children) - 1; }

  OrientedBox box(std::size_t k) const {
    ShortAxes axes;
    OrientedBox out;
    for (std::size_t i = 0; i < 3; ++i) {
      out.centre[i] = centre[i][k], out.half[i] = half[i][k];
      for (std::size_t j = 0; j < 2; ++j) axes[j][i] = axis[j][i][k];
    }
    out.axis = unpacked(axes);
    return out;
  }
  BoxedNode boxed(std::size_t k) const { return {child(k), box(k)}; }
};

// The triangles of a node, as they were given; the last one of them is in all lanes that are left.
struct alignas(64) EightTriangles {
  std::array<std::array<std::array<double, kTreeWidth>, 3>, 3> place;  // by corner, axis, and triangle

  std::array<Vec3, 3> corners(std::size_t k) const {
    const auto corner = [&](std::size_t i) { return Vec3{place[i][0][k], place[i][1][k], place[i][2][k]}; };
    return {corner(0), corner(1), corner(2)};
  }
};

struct TriangleTree {
  static constexpr std::size_t kMostLevels = 11;  // over 2^31 triangles

  Vec3 middle;
  double units = 1;  // a length in m times this is one in the tree's; a power of two
  OrientedBox root{};
  std::vector<TriangleNode> nodes;     // the root's first
  std::vector<EightTriangles> leaves;  // all full but the last one

  // The corners of a triangle by its place.
  std::array<Vec3, 3> corners(std::int32_t triangle) const {
    const auto index = static_cast<std::size_t>(triangle);
    return leaves[index / kTreeWidth].corners(index % kTreeWidth);
  }
};

// Sorts the triangles into the tree's order; `source` says where each was. There is at least one triangle. `own_axes`:
// whether boxes have axes of their own; those along the frame's axes are the plain ones.
TriangleTree build_triangle_tree(const std::vector<Vec3>& points, std::vector<MeshTriangle>& triangles,
                                 std::vector<std::int32_t>& source, bool own_axes);

}  // namespace plannercheck
