// Convex hulls as triangle meshes, exact: every sign is that of the given doubles.
//
// In: points, or points with faces that claim to be their hull. Out: a mesh whose vertices are exactly the extreme
// points and whose triangles are outward; triangles of one facet are exactly coplanar. Idea: triangles around all
// points (quickhull.hpp); an exact sign at each edge tells whether the surface bends there, and corners at which fewer
// than three edges bend are left out.
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

using Triangle = std::array<int, 3>;

inline int next_corner(int corner) { return corner == 2 ? 0 : corner + 1; }

struct ConvexMesh {
  std::vector<Vec3> vertices;
  std::vector<int> source;           // index into the given points, per vertex
  std::vector<Triangle> triangles;   // counter-clockwise seen from outside
  std::vector<Triangle> neighbours;  // neighbours[t][i]: the triangle across the edge from corner i to corner i + 1
  std::vector<std::array<bool, 3>> strict;  // the edge is a true one: the facets on both sides are not coplanar
};

// What is wrong with the input, in words that fit behind the name of the body.
class HullError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws HullError if the points have no volume.
ConvexMesh convex_hull(const std::vector<Vec3>& points);

// Verifies that triangles bound the convex hull of their points; throws HullError if not (Mehlhorn et al. 1999:
// closed, locally convex, and a ray from an interior point leaves through one triangle only). `inside`: an interior
// point, if one is known; else one is looked for.
ConvexMesh verified_hull(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                         const Vec3* inside = nullptr);

// A point strictly inside, near the centre of the volume; none if the body is thinner than the grid of doubles.
std::optional<Vec3> interior_point(const ConvexMesh& mesh);

// The facet of each triangle: triangles that are exactly coplanar share a number, counted from 0.
std::vector<int> facets(const ConvexMesh& mesh, int* count);

}  // namespace plannercheck
