#include "oracle/mesh.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace plannercheck::oracle {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// For each vertex the first one, in the order of coordinates, that lies where it does.
std::vector<std::uint32_t> places_of(const std::vector<double>& coordinates) {
  const auto at = [&](std::uint32_t vertex) {
    const double* v = coordinates.data() + std::size_t{3} * vertex;
    return std::array<double, 3>{v[0], v[1], v[2]};
  };
  std::vector<std::uint32_t> order(coordinates.size() / 3), places(order.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return at(a) < at(b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_new = i == 0 || at(order[i]) != at(order[i - 1]);
    places[order[i]] = is_new ? order[i] : places[order[i - 1]];
  }
  return places;
}

bool edges_cancel(const Triangles& triangles, const std::vector<std::uint32_t>& places) {
  // By the smaller and the larger end: how often the edge runs upwards less how often it runs downwards.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::int64_t> surplus;
  for (const auto& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = places[triangle[k]], to = places[triangle[(k + 1) % 3]];
      if (from < to) ++surplus[{from, to}];
      if (from > to) --surplus[{to, from}];
    }
  }
  return std::all_of(surplus.begin(), surplus.end(), [](const auto& edge) { return edge.second == 0; });
}

std::vector<std::uint32_t> one_of_each_component(const Triangles& triangles, const std::vector<std::uint32_t>& places) {
  std::vector<std::uint32_t> parents(places.size());
  std::iota(parents.begin(), parents.end(), 0U);
  const auto root = [&](std::uint32_t vertex) {
    while (parents[vertex] != vertex) vertex = parents[vertex] = parents[parents[vertex]];
    return vertex;
  };
  for (const auto& triangle : triangles) {
    const std::uint32_t first = root(places[triangle[0]]);
    parents[root(places[triangle[1]])] = first;
    parents[root(places[triangle[2]])] = root(first);
  }
  std::vector<std::uint32_t> roots;
  for (const auto& triangle : triangles) roots.push_back(root(places[triangle[0]]));
  std::sort(roots.begin(), roots.end());
  roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
  return roots;
}

}  // namespace

Mesh::Mesh(const double* vertices, std::size_t vertex_count, const std::int32_t* corners, std::size_t triangle_count,
           double radius)
    : points(vertices, vertex_count, radius),
      coordinates(vertices, vertices + 3 * vertex_count),
      inflation_radius(radius) {
  for (std::size_t i = 0; i < triangle_count; ++i) {
    const std::int32_t* c = corners + 3 * i;
    triangles.push_back(
        {static_cast<std::uint32_t>(c[0]), static_cast<std::uint32_t>(c[1]), static_cast<std::uint32_t>(c[2])});
  }
  const std::vector<std::uint32_t> places = places_of(coordinates);
  is_closed = edges_cancel(triangles, places);
  component_vertices = one_of_each_component(triangles, places);
}

}  // namespace plannercheck::oracle
