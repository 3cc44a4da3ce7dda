#include "bodies/triangulation.hpp"

#include <algorithm>

#include "math/predicates.hpp"

namespace plannercheck {
namespace {

std::int32_t after(std::int32_t half_edge) { return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1; }
std::int32_t before(std::int32_t half_edge) { return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1; }

}  // namespace

Triangulation::Triangulation(const ConvexMesh& mesh)
    : points_(mesh.vertices), leaving_(mesh.vertices.size(), -1), degree_(mesh.vertices.size(), 0) {
  corner_.resize(mesh.triangles.size() * 3);
  twin_.resize(corner_.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t v = mesh.triangles[t][i];
      corner_[3 * t + i] = v;
      leaving_[at(v)] = static_cast<std::int32_t>(3 * t + i);
      ++degree_[at(v)];
    }
  }
  for (std::size_t h = 0; h < corner_.size(); ++h) {
    const std::int32_t end = corner_[at(after(static_cast<std::int32_t>(h)))];
    const std::int32_t other = mesh.neighbours[h / 3][h % 3];
    for (std::int32_t i = 0; i < 3; ++i) {
      if (corner_[at(3 * other + i)] == end) twin_[h] = 3 * other + i;
    }
  }
}

std::vector<std::int32_t> Triangulation::ring(std::int32_t v) const {
  std::vector<std::int32_t> ring;
  const std::int32_t start = leaving_[at(v)];
  std::int32_t h = start;
  do {
    ring.push_back(corner_[at(after(h))]);
    h = twin_[at(before(h))];
  } while (h != start);
  // Starts at the lowest index, so that the closing of coplanar holes depends on the surface alone, not on its history.
  std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
  return ring;
}

void Triangulation::link(std::int32_t a, std::int32_t b) {
  twin_[at(a)] = b;
  twin_[at(b)] = a;
}

void Triangulation::remove(std::int32_t v, const std::vector<std::int32_t>& ring) {
  std::vector<std::int32_t> outer;  // outer[i]: the half-edge on the far side of ring[i] -> ring[i + 1]
  std::int32_t h = leaving_[at(v)];
  while (corner_[at(after(h))] != ring.front()) h = twin_[at(before(h))];
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const std::int32_t next = twin_[at(before(h))];
    outer.push_back(twin_[at(after(h))]);
    free_.push_back(h / 3);
    for (std::int32_t k = 0; k < 3; ++k) corner_[at(h - h % 3 + k)] = -1;
    h = next;
  }
  degree_[at(v)] = 0;
  for (const std::int32_t n : ring) degree_[at(n)] -= 2;  // triangles lost; `fill` counts the new ones
  const std::int32_t base = fill(ring, outer, 0, ring.size() - 1);
  link(base, outer.back());
}

// Fills the polygon ring[from..to] whose edge ring[to] -> ring[from] is given; returns the half-edge along it. The
// ring's vertices are in convex position, so no three are collinear; among coplanar ones any choice gives a facet.
std::int32_t Triangulation::fill(const std::vector<std::int32_t>& ring, const std::vector<std::int32_t>& outer,
                                 std::size_t from, std::size_t to) {
  const Vec3 a = points_[at(ring[from])], b = points_[at(ring[to])];
  std::size_t tip = from + 1;
  for (std::size_t candidate = tip + 1; candidate < to; ++candidate) {
    if (orientation(a, points_[at(ring[tip])], b, points_[at(ring[candidate])]) > 0) tip = candidate;
  }
  const std::int32_t t = free_.back();
  free_.pop_back();
  const std::int32_t corners[3] = {ring[from], ring[tip], ring[to]};
  for (std::int32_t i = 0; i < 3; ++i) {
    corner_[at(3 * t + i)] = corners[i];
    leaving_[at(corners[i])] = 3 * t + i;
    ++degree_[at(corners[i])];
  }
  link(3 * t, tip == from + 1 ? outer[from] : fill(ring, outer, from, tip));
  link(3 * t + 1, to == tip + 1 ? outer[tip] : fill(ring, outer, tip, to));
  return 3 * t + 2;
}

bool Triangulation::is_convex() const {
  for (std::size_t h = 0; h < corner_.size(); ++h) {
    const auto edge = static_cast<std::int32_t>(h);
    if (corner_[h] < 0) continue;
    const std::int32_t far = corner_[at(before(twin_[h]))];
    if (orientation(points_[at(corner_[h])], points_[at(corner_[at(after(edge))])],
                    points_[at(corner_[at(before(edge))])], points_[at(far)]) > 0)
      return false;
  }
  return true;
}

}  // namespace plannercheck
