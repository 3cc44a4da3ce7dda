// Boxes around the triangles of a mesh: a tree with eight children a node, in floats that fit one register.
//
// In: points and triangles. Out: triangles in the order of the leaves, and nodes whose boxes hold what is below them.
// Boxes are along the mesh's axes, in units in which the mesh reaches from −1 to 1 about its middle; they are rounded
// outwards, so that a point that is outside of a box, beyond the rounding of its own coordinates, is on no triangle
// below it. The children of a node are all nodes, or all triangles, whose corners then lie side by side in lanes.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

using MeshTriangle = std::array<std::int32_t, 3>;

inline constexpr std::size_t kTreeWidth = 8;

// Half extents are rounded up.
struct FloatBox {
  std::array<float, 3> centre, half;
};

struct TriangleNode {
  std::array<std::array<float, kTreeWidth>, 3> centre, half;  // by axis, then by child
  std::array<std::int32_t, kTreeWidth> child;                 // see TriangleTree
  std::int32_t leaf = -1;                                     // its triangles' place among the tree's leaves; −1: nodes

  FloatBox box(std::size_t k) const {
    return {{centre[0][k], centre[1][k], centre[2][k]}, {half[0][k], half[1][k], half[2][k]}};
  }
};

// The triangles of a node, as they were given; the last one of them is in all lanes that are left.
struct EightTriangles {
  std::array<std::array<std::array<double, kTreeWidth>, 3>, 3> corner;  // by corner, axis, and triangle
  std::size_t count = 0;
};

struct TriangleTree {
  // A child is a node, or the complement of a triangle's place; such a one is none, and its half extents are −∞.
  static constexpr std::int32_t kNothing = std::numeric_limits<std::int32_t>::min();
  static constexpr std::size_t kMostLevels = 11;  // over 2^31 triangles

  Vec3 middle;
  double units = 1;  // a length in m times this is one in the tree's; a power of two
  FloatBox root{};
  std::vector<TriangleNode> nodes;  // the root's first
  std::vector<EightTriangles> leaves;

  // The first triangle below a child, and those below it are up to the first one below the next child.
  std::int32_t first_below(std::int32_t child) const {
    while (child >= 0) child = nodes[at(child)].child[0];
    return ~child;
  }
};

// Sorts the triangles into the tree's order; `source` says where each was. There is at least one triangle.
TriangleTree build_triangle_tree(const std::vector<Vec3>& points, std::vector<MeshTriangle>& triangles,
                                 std::vector<std::int32_t>& source);

}  // namespace plannercheck
