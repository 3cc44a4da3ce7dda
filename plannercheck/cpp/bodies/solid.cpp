#include "bodies/solid.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <utility>

#include "bodies/hull.hpp"
#include "bodies/polytope.hpp"

namespace plannercheck {
namespace {

bool is_before(Vec3 a, Vec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

// Gives points that are used and have equal coordinates one index, in triangles; the points in order, each once.
std::vector<Vec3> merge_points(const std::vector<Vec3>& given, std::vector<MeshTriangle>& triangles) {
  std::vector<std::int32_t> order;
  std::vector<bool> is_used(given.size(), false);
  for (const MeshTriangle& t : triangles) {
    for (const std::int32_t corner : t) {
      if (corner < 0 || at(corner) >= given.size())
        throw HullError("a triangle names vertex " + std::to_string(corner) + " of " + std::to_string(given.size()));
      if (!is_used[at(corner)]) order.push_back(corner);
      is_used[at(corner)] = true;
    }
  }
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return is_before(given[at(a)], given[at(b)]); });
  std::vector<Vec3> points;
  std::vector<std::int32_t> place(given.size(), -1);
  for (const std::int32_t p : order) {
    const Vec3 point = given[at(p)] + Vec3{};  // -0 becomes 0
    if (points.empty() || !(points.back() == point)) points.push_back(point);
    place[at(p)] = static_cast<std::int32_t>(points.size()) - 1;
  }
  for (MeshTriangle& t : triangles) {
    for (std::int32_t& corner : t) corner = place[at(corner)];
  }
  return points;
}

// Whether each edge is run along as often as its reverse. A triangle with a repeated corner runs to and fro.
bool edges_cancel(const std::vector<MeshTriangle>& triangles) {
  std::vector<std::array<std::int32_t, 3>> edges;  // lower end, upper end, +1 upwards or −1
  edges.reserve(3 * triangles.size());
  for (const MeshTriangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t a = t[i], b = t[i == 2 ? 0 : i + 1];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t k = 0; k < edges.size();) {
    int sum = 0;
    std::size_t end = k;
    while (end < edges.size() && edges[end][0] == edges[k][0] && edges[end][1] == edges[k][1]) sum += edges[end++][2];
    if (sum != 0) return false;
    k = end;
  }
  return true;
}

class Parts {
 public:
  explicit Parts(std::size_t count) : parent_(indices_below(count)) {}

  void join(std::int32_t a, std::int32_t b) { parent_[at(find(a))] = find(b); }
  std::int32_t find(std::int32_t a) {
    while (parent_[at(a)] != a) a = parent_[at(a)] = parent_[at(parent_[at(a)])];
    return a;
  }

 private:
  std::vector<std::int32_t> parent_;
};

void find_components(Solid& solid) {
  const std::size_t points = solid.points.size();
  Parts parts(points);
  for (const MeshTriangle& t : solid.triangles) parts.join(t[0], t[1]), parts.join(t[1], t[2]);
  std::vector<std::int32_t> place(points);  // among the components
  for (std::size_t p = 0; p < points; ++p) {
    const auto index = static_cast<std::int32_t>(p);
    if (parts.find(index) != index) continue;
    place[p] = static_cast<std::int32_t>(solid.components.size());
    solid.components.push_back(index);
    solid.extremes.push_back({index, index, index, index, index, index});
  }
  for (std::size_t p = 0; p < points; ++p) {
    const auto index = static_cast<std::int32_t>(p);
    auto& extremes = solid.extremes[at(place[at(parts.find(index))])];
    for (std::size_t k = 0; k < extremes.size(); ++k) {
      const int axis = static_cast<int>(k / 2);
      const double own = solid.points[p][axis], known = solid.points[at(extremes[k])][axis];
      if (k % 2 == 0 ? own < known : own > known) extremes[k] = index;
    }
  }
}

}  // namespace

Solid prepare_solid(const std::vector<Vec3>& points, const std::vector<MeshTriangle>& triangles, bool own_axes) {
  if (triangles.empty()) throw HullError("it has no triangles");
  Solid solid;
  solid.triangles = triangles;
  solid.points = merge_points(points, solid.triangles);
  solid.is_closed = edges_cancel(solid.triangles);
  find_components(solid);
  solid.tree = build_triangle_tree(solid.points, solid.triangles, solid.source, own_axes);
  for (const Vec3& p : solid.points) solid.reach = larger(solid.reach, absolute(p));
  return solid;
}

Solid surface_of(const Polytope& body) {
  std::vector<MeshTriangle> triangles(body.triangles.begin(), body.triangles.end());
  const auto count = static_cast<std::int32_t>(body.inner.points.size());
  if (count <= 2) triangles.push_back({0, count - 1, count - 1});
  // The corners of a polygon are in cyclic order.
  for (std::int32_t k = 2; body.dimension == 2 && k < count; ++k) triangles.push_back({0, k - 1, k});
  return prepare_solid(body.inner.points, triangles);
}

std::size_t Solid::bytes() const {
  return sizeof *this + points.size() * sizeof(Vec3) + triangles.size() * (sizeof(MeshTriangle) + sizeof(source[0])) +
         tree.nodes.size() * sizeof(TriangleNode) + tree.leaves.size() * sizeof(EightTriangles) +
         components.size() * (sizeof(components[0]) + sizeof(extremes[0]));
}

}  // namespace plannercheck
