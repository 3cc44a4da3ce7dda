#include "bodies/flat_hull.hpp"

#include <algorithm>

#include "math/predicates.hpp"

namespace plannercheck {
namespace {

FlatHull pick(const std::vector<Vec3>& points, int dimension, const std::vector<int>& indices) {
  FlatHull hull;
  hull.dimension = dimension;
  hull.source = indices;
  for (const int i : indices) hull.vertices.push_back(points[at(i)]);
  return hull;
}

// The ends of collinear points: the extremes of any coordinate that is not constant.
std::vector<int> segment_ends(const std::vector<Vec3>& points, const AffineSpan& span) {
  const Vec3 a = points[at(span.index[0])], b = points[at(span.index[1])];
  const int axis = a.x != b.x ? 0 : a.y != b.y ? 1 : 2;
  const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                               [&](const Vec3& p, const Vec3& q) { return p[axis] < q[axis]; });
  return {static_cast<int>(low - points.begin()), static_cast<int>(high - points.begin())};
}

// Andrew's monotone chain on the projection along an axis that the plane does not contain, so that it is one-to-one.
std::vector<int> polygon_corners(const std::vector<Vec3>& points, const AffineSpan& span) {
  const Vec3 a = points[at(span.index[0])], b = points[at(span.index[1])], c = points[at(span.index[2])];
  int axis = 0;  // the normal's largest: turns are then clear in doubles
  const Vec3 normal = cross(b - a, c - a);
  for (int i = 1; i < 3; ++i) axis = std::fabs(normal[i]) > std::fabs(normal[axis]) ? i : axis;
  while (turn(a, b, c, axis) == 0) axis = (axis + 1) % 3;
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  std::vector<int> order = indices_below(points.size());
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    const Vec3 &p = points[at(i)], &q = points[at(j)];
    return p[first] != q[first] ? p[first] < q[first] : p[second] < q[second];
  });
  std::vector<int> chain;
  const auto sweep = [&](auto from, auto to) {
    const std::size_t base = chain.size();
    for (; from != to; ++from) {
      while (chain.size() >= base + 2 &&
             turn(points[at(chain[chain.size() - 2])], points[at(chain.back())], points[at(*from)], axis) <= 0) {
        chain.pop_back();
      }
      chain.push_back(*from);  // the turns of repeated points are 0, so they leave again
    }
    chain.pop_back();  // the other sweep begins with this point
  };
  sweep(order.begin(), order.end());
  sweep(order.rbegin(), order.rend());
  return chain;
}

}  // namespace

FlatHull flat_hull(const std::vector<Vec3>& points, const AffineSpan& span) {
  if (span.dimension == 0) return pick(points, 0, {0});
  if (span.dimension == 1) return pick(points, 1, segment_ends(points, span));
  return pick(points, 2, polygon_corners(points, span));
}

namespace {

// Removes every other corner until at most `most` are left.
std::vector<Removal> halve(std::vector<std::int32_t>& alive, std::size_t most, std::int32_t* depth) {
  std::vector<Removal> removals;
  for (*depth = 0; alive.size() > most; ++*depth) {
    std::vector<std::int32_t> kept;
    for (std::size_t i = 0; i < alive.size(); ++i) {
      if (i % 2 == 0) {
        kept.push_back(alive[i]);
      } else {
        removals.push_back({alive[i], *depth, {alive[i - 1], alive[(i + 1) % alive.size()]}});
      }
    }
    alive = std::move(kept);
  }
  return removals;
}

}  // namespace

Hierarchy build_flat_hierarchy(const FlatHull& hull) {
  std::vector<std::int32_t> alive = indices_below(hull.vertices.size());
  std::int32_t depth = 0;
  const std::vector<Removal> removals = halve(alive, kUnlayered, &depth);
  Hierarchy h{lay_out(hull.vertices, removals, alive, depth), {}};
  const std::vector<Removal> further = halve(alive, kHighestTop, &depth);
  h.top_levels = lay_out_top_levels(h, further, alive, depth);
  return h;
}

}  // namespace plannercheck
