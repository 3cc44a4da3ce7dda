// A solid: the closed set of a mesh's triangles and of all points around which it winds.
//
// In: points, and triangles that name three of them each. Out: the triangles in the order of a tree, whether they bound
// a volume, and a vertex of each connected part. A mesh bounds a volume if each directed edge occurs as often as its
// reverse, where vertices with equal coordinates are one vertex. Then every point off the triangles has a winding
// number, and the points whose number is not 0 belong to the solid. Otherwise the solid is its triangles alone.
// Crossing, nested, inverted and degenerate triangles are allowed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bodies/triangle_tree.hpp"
#include "math/vec.hpp"

namespace plannercheck {

struct Polytope;

struct Solid {
  std::vector<Vec3> points;             // all different; -0 is 0
  std::vector<MeshTriangle> triangles;  // indices into points, in the tree's order
  std::vector<std::int32_t> source;     // per triangle: index into those that were given
  TriangleTree tree;
  bool is_closed = false;                             // whether it has points around which it winds
  std::vector<std::int32_t> components;               // a vertex of each part that hangs together by vertices
  std::vector<std::array<std::int32_t, 6>> extremes;  // of each part, the first and last vertices along the axes
  Vec3 reach;                                         // largest |x|, |y|, |z| of the points

  std::size_t bytes() const;
};

// Throws HullError if there are no triangles, or one names a point that is not there. `own_axes`: see
// build_triangle_tree.
Solid prepare_solid(const std::vector<Vec3>& points, const std::vector<MeshTriangle>& triangles, bool own_axes = true);

// The surface of a convex body, without its inflation radius; of one without volume the polygon, segment or point.
Solid surface_of(const Polytope& body);

}  // namespace plannercheck
