// A triangle mesh as a set: its triangles, and where it is closed also every point with a winding number other than 0.
//
// In: points, m, triangles of them, an inflation radius, m. Out: whether its directed edges cancel, and its components.
// Vertices with equal coordinates are one vertex. Triangles may be segments or points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "oracle/posed_points.hpp"

namespace plannercheck::oracle {

struct Mesh {
  Points points;
  std::vector<double> coordinates;  // of the points, row-major
  std::vector<std::array<std::uint32_t, 3>> triangles;
  double inflation_radius;
  // Every directed edge occurs as often as its reverse.
  bool is_closed = false;
  // One vertex of each set of triangles that hang together by their vertices.
  std::vector<std::uint32_t> component_vertices;

  // `corners`: three indices a triangle, each below the number of points.
  Mesh(const double* vertices, std::size_t vertex_count, const std::int32_t* corners, std::size_t triangle_count,
       double radius);
};

}  // namespace plannercheck::oracle
