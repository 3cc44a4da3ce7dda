// Whether a triangle shares a point with some of eight others, in lanes of doubles.
//
// In: a triangle, rounded, and a leaf of a tree in the same frame, with the number of its triangles. Out: the leaf's
// triangles that surely meet it, and the triangles that rounding leaves open; the others are surely apart. Idea: as in
// triangle_pair.hpp. Bodies may be inflated: triangles are apart if a plane of one of them keeps the other one further
// away.
#pragma once

#include "bodies/triangle_tree.hpp"
#include "narrow_phase/triangle_pair.hpp"

namespace plannercheck {

// Bit k: triangle k of the leaf.
struct TriangleLanes {
  unsigned meet = 0, open = 0;
};

// `error`: how far each coordinate of `corners` may be from the exact one. `spread`: by how much coordinates of corners
// of all these triangles differ at most. `reach`: how far from the triangles points of both bodies together may be.
TriangleLanes triangle_against(const TriangleCorners& corners, double error, const EightTriangles& leaf,
                               std::size_t count, double spread, double reach);

}  // namespace plannercheck
