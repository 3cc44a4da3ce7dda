// Convex hulls as triangle meshes, exact for the given doubles.
//
// In: points, or points with faces that claim to be their hull. Out: a mesh whose vertices are exactly the extreme
// points and whose triangles are outward; triangles of one facet are exactly coplanar. Idea: quickhull.hpp builds
// triangles around all points; exact signs find the edges that bend; corners with fewer than three such edges are
// removed.
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
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
  std::vector<std::array<bool, 3>> strict;  // a true edge: the facets on both sides are not coplanar
};

// Says what is wrong with the input, in words that can follow the name of the body.
class HullError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws HullError if the points have no volume.
ConvexMesh convex_hull(const std::vector<Vec3>& points);

// Verifies that triangles bound the convex hull of their points, else throws HullError (Mehlhorn et al. 1999: closed,
// locally convex, and a ray from an interior point leaves through one triangle only). `inside`: an interior point or
// none.
ConvexMesh verified_hull(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                         const Vec3* inside = nullptr);

// A point strictly inside, near the centre of the volume; none if the body is thinner than the grid of doubles.
std::optional<Vec3> interior_point(const ConvexMesh& mesh);

// The facet of each triangle: triangles that are exactly coplanar share a number, counted from 0.
std::vector<int> facets(const ConvexMesh& mesh, int* count);

}  // namespace plannercheck
