#include "bodies/hull.hpp"

#include <algorithm>
#include <tuple>

#include "bodies/quickhull.hpp"
#include "math/predicates.hpp"

namespace plannercheck {
namespace {

// Links the triangles of a closed surface across their edges; throws unless each edge has exactly two opposite sides.
std::vector<Triangle> linked_neighbours(const std::vector<Triangle>& triangles) {
  struct Side {
    int low, high, half_edge;
    bool upwards;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const int a = triangles[t][at(i)], b = triangles[t][at(next_corner(i))];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int>(3 * t) + i, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.half_edge) < std::tie(b.low, b.high, b.half_edge);
  });
  std::vector<Triangle> neighbours(triangles.size());
  for (std::size_t k = 0; k < sides.size(); k += 2) {
    const auto same_edge = [&](std::size_t other) {
      return other < sides.size() && sides[other].low == sides[k].low && sides[other].high == sides[k].high;
    };
    const std::string edge =
        "the edge between vertices " + std::to_string(sides[k].low) + " and " + std::to_string(sides[k].high);
    if (!same_edge(k + 1)) throw HullError("its faces are not closed: " + edge + " has a face on one side only");
    if (same_edge(k + 2) || sides[k].upwards == sides[k + 1].upwards) {
      throw HullError("its faces are not oriented alike: " + edge + " is run along twice in the same direction");
    }
    const int a = sides[k].half_edge, b = sides[k + 1].half_edge;
    neighbours[at(a / 3)][at(a % 3)] = b / 3;
    neighbours[at(b / 3)][at(b % 3)] = a / 3;
  }
  return neighbours;
}

int opposite_corner(const Triangle& triangle, int a, int b) {
  for (const int corner : triangle) {
    if (corner != a && corner != b) return corner;
  }
  return -1;
}

// Marks the edges at which the surface bends; throws if it bends inwards.
std::vector<std::array<bool, 3>> bends(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles,
                                       const std::vector<Triangle>& neighbours) {
  std::vector<std::array<bool, 3>> strict(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& v = triangles[t];
    for (int i = 0; i < 3; ++i) {
      const int a = v[at(i)], b = v[at(next_corner(i))], other = neighbours[t][at(i)];
      if (at(other) < t) {  // decided on the other side
        const Triangle& w = triangles[at(other)];
        const int edge = w[0] == b ? 0 : w[1] == b ? 1 : 2;
        strict[t][at(i)] = strict[at(other)][at(edge)];
        continue;
      }
      const int far = opposite_corner(triangles[at(other)], a, b);
      const int side = orientation(points[at(v[0])], points[at(v[1])], points[at(v[2])], points[at(far)]);
      if (side > 0) {
        throw HullError("its faces are not convex: vertex " + std::to_string(far) + " sticks out of the face " +
                        std::to_string(v[0]) + " " + std::to_string(v[1]) + " " + std::to_string(v[2]));
      }
      strict[t][at(i)] = side < 0;
    }
  }
  return strict;
}

// A vertex is extreme if and only if at least three true edges meet there; else it lies within a facet or an edge.
std::vector<bool> extreme_vertices(const std::vector<Triangle>& triangles,
                                   const std::vector<std::array<bool, 3>>& strict, std::size_t vertex_count) {
  std::vector<int> edges(vertex_count, 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) edges[at(triangles[t][at(i)])] += strict[t][at(i)] ? 1 : 0;
  }
  std::vector<bool> extreme(vertex_count);
  for (std::size_t v = 0; v < vertex_count; ++v) extreme[v] = edges[v] >= 3;
  return extreme;
}

// Numbers the vertices in use and classifies the edges.
ConvexMesh compact(const std::vector<Vec3>& points, const std::vector<int>& source,
                   const std::vector<Triangle>& triangles, std::vector<Triangle> neighbours) {
  ConvexMesh mesh;
  std::vector<int> number(points.size(), -1);
  for (const Triangle& triangle : triangles) {
    for (const int corner : triangle) number[at(corner)] = 0;
  }
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(points[p]);
    mesh.source.push_back(source[p]);
  }
  for (const Triangle& t : triangles) mesh.triangles.push_back({number[at(t[0])], number[at(t[1])], number[at(t[2])]});
  mesh.neighbours = std::move(neighbours);
  mesh.strict = bends(mesh.vertices, mesh.triangles, mesh.neighbours);
  return mesh;
}

ConvexMesh hull_of(const std::vector<Vec3>& points, const std::vector<int>& source) {
  TriangleSurface surface = quickhull(points);
  ConvexMesh mesh = compact(points, source, surface.triangles, std::move(surface.neighbours));
  const std::vector<bool> extreme = extreme_vertices(mesh.triangles, mesh.strict, mesh.vertices.size());
  if (std::find(extreme.begin(), extreme.end(), false) == extreme.end()) return mesh;
  std::vector<Vec3> kept;
  std::vector<int> kept_source;
  for (std::size_t v = 0; v < extreme.size(); ++v) {
    if (!extreme[v]) continue;
    kept.push_back(mesh.vertices[v]);
    kept_source.push_back(mesh.source[v]);
  }
  return hull_of(kept, kept_source);
}

// How many triangles the ray from `inside` to the middle of a triangle meets; touching counts.
int triangles_hit(const ConvexMesh& mesh, Vec3 inside, const Triangle& aim) {
  const Vec3 middle = (1.0 / 3.0) * (mesh.vertices[at(aim[0])] + mesh.vertices[at(aim[1])] + mesh.vertices[at(aim[2])]);
  const Vec3 ray = middle - inside;
  int hits = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[at(t[0])], b = mesh.vertices[at(t[1])], c = mesh.vertices[at(t[2])];
    if (cone_side(ray, inside, a, b) >= 0 && cone_side(ray, inside, b, c) >= 0 && cone_side(ray, inside, c, a) >= 0)
      ++hits;
  }
  return hits;
}

// A surface that winds k times around a point meets every ray from it at least k times, so one ray with a single hit is
// a proof. A ray to a sliver may be rounded onto an edge and hit two triangles; others are then tried.
bool winds_once(const ConvexMesh& mesh, Vec3 inside) {
  constexpr std::size_t kRays = 16;
  const std::size_t stride = (mesh.triangles.size() + kRays - 1) / kRays;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += stride) {
    if (triangles_hit(mesh, inside, mesh.triangles[t]) == 1) return true;
  }
  return false;
}

// For bodies too thin for rays from an interior point: tests every vertex against every face.
bool no_vertex_outside(const ConvexMesh& mesh) {
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    return std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [&](Vec3 v) {
      return orientation(mesh.vertices[at(t[0])], mesh.vertices[at(t[1])], mesh.vertices[at(t[2])], v) <= 0;
    });
  });
}

bool strictly_inside(const ConvexMesh& mesh, Vec3 point) {
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    return orientation(mesh.vertices[at(t[0])], mesh.vertices[at(t[1])], mesh.vertices[at(t[2])], point) < 0;
  });
}

Vec3 volume_centre(const ConvexMesh& mesh) {
  const Vec3 base = mesh.vertices.front();
  Vec3 sum;
  double volume = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[at(t[0])] - base, b = mesh.vertices[at(t[1])] - base,
               c = mesh.vertices[at(t[2])] - base;
    const double part = dot(cross(a, b), c);
    volume += part;
    sum = sum + (part / 4) * (a + b + c);
  }
  return base + (1 / volume) * sum;
}

Vec3 vertex_mean(const ConvexMesh& mesh) {
  const Vec3 base = mesh.vertices.front();
  Vec3 sum;
  for (const Vec3& v : mesh.vertices) sum = sum + (v - base);
  return base + (1 / static_cast<double>(mesh.vertices.size())) * sum;
}

}  // namespace

ConvexMesh convex_hull(const std::vector<Vec3>& points) { return hull_of(points, indices_below(points.size())); }

ConvexMesh verified_hull(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles, const Vec3* inside) {
  if (triangles.size() < 4) throw HullError("it has fewer than 4 faces");
  ConvexMesh mesh = compact(points, indices_below(points.size()), triangles, linked_neighbours(triangles));
  if (mesh.vertices.size() != points.size()) throw HullError("a vertex belongs to no face");
  if (triangles.size() != 2 * points.size() - 4) throw HullError("its faces do not form a sphere (V − E + F is not 2)");
  const std::vector<bool> extreme = extreme_vertices(mesh.triangles, mesh.strict, mesh.vertices.size());
  const auto flat = std::find(extreme.begin(), extreme.end(), false);
  if (flat != extreme.end()) {
    throw HullError("vertex " + std::to_string(flat - extreme.begin()) + " is no corner of the faces around it");
  }
  const bool known = inside != nullptr && strictly_inside(mesh, *inside);
  const std::optional<Vec3> origin = known ? *inside : interior_point(mesh);
  if (!(origin && winds_once(mesh, *origin)) && !no_vertex_outside(mesh)) {
    throw HullError("its faces wind around it more than once");
  }
  return mesh;
}

std::optional<Vec3> interior_point(const ConvexMesh& mesh) {
  for (const Vec3 candidate : {volume_centre(mesh), vertex_mean(mesh)}) {
    if (std::isfinite(norm_1(candidate)) && strictly_inside(mesh, candidate)) return candidate;
  }
  return {};
}

std::vector<int> facets(const ConvexMesh& mesh, int* count) {
  std::vector<int> facet(mesh.triangles.size(), -1);
  std::vector<int> stack;
  *count = 0;
  for (std::size_t seed = 0; seed < facet.size(); ++seed) {
    if (facet[seed] >= 0) continue;
    facet[seed] = *count;
    stack = {static_cast<int>(seed)};
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (int i = 0; i < 3; ++i) {
        const int n = mesh.neighbours[at(t)][at(i)];
        if (mesh.strict[at(t)][at(i)] || facet[at(n)] >= 0) continue;
        facet[at(n)] = *count;
        stack.push_back(n);
      }
    }
    ++*count;
  }
  return facet;
}

}  // namespace plannercheck
