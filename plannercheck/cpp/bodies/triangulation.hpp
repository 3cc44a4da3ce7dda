// A triangulated convex surface from which vertices can be removed; each hole is closed convexly.
//
// Half-edge h = 3 t + i runs from corner i of triangle t to corner i + 1, counter-clockwise seen from outside.
#pragma once

#include <cstdint>
#include <vector>

#include "bodies/hull.hpp"

namespace plannercheck {

class Triangulation {
 public:
  explicit Triangulation(const ConvexMesh& mesh);

  const std::vector<Vec3>& points() const { return points_; }
  std::int32_t degree(std::int32_t v) const { return degree_[static_cast<std::size_t>(v)]; }
  bool contains(std::int32_t v) const { return degree(v) > 0; }
  // The neighbours of v, counter-clockwise, starting with the lowest index.
  std::vector<std::int32_t> ring(std::int32_t v) const;
  // Removes v, whose ring is given, and closes the hole with the convex hull of the remaining points (gift wrapping).
  void remove(std::int32_t v, const std::vector<std::int32_t>& ring);
  // Whether every edge is convex, decided exactly.
  bool is_convex() const;

 private:
  const std::vector<Vec3>& points_;
  std::vector<std::int32_t> corner_;  // start of each half-edge; -1 in dead triangles
  std::vector<std::int32_t> twin_;
  std::vector<std::int32_t> leaving_;  // some half-edge that starts at the vertex
  std::vector<std::int32_t> degree_;
  std::vector<std::int32_t> free_;  // dead triangles to be reused

  std::int32_t fill(const std::vector<std::int32_t>& ring, const std::vector<std::int32_t>& outer, std::size_t from,
                    std::size_t to);
  void link(std::int32_t a, std::int32_t b);
};

}  // namespace plannercheck
