#include "bodies/hull_dents.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "bodies/polytope.hpp"
#include "bodies/solid.hpp"
#include "bodies/solid_interior.hpp"

namespace plannercheck {
namespace {

// Solids with deeper dents are better known by the balls and boxes inside of them.
constexpr double kDeepestDent = 1.0 / 16;

// The error of q·y, as a part of the largest |q| times the largest |y|: polar points err by 4u, y by 1u, the product by
// 3u, and the difference from 1 and the sum with this bound by 1u each of at most 2.
constexpr double kDentError = 32 * 0x1p-53;

// So many facets at most are looked at one by one, if their dents are deeper than this.
constexpr std::size_t kNamedFacets = 32;
constexpr double kShallow = 1e-5;

// The polar points, each with those that are joined to it by an edge of the polar.
class FacetSearch {
 public:
  explicit FacetSearch(const Polytope& hull) : points_(hull.polar.points), first_(points_.size() + 1) {
    const auto each_edge = [&](auto take) {
      for (const Triangle& t : hull.polar_triangles) {
        for (std::size_t k = 0; k < 3; ++k) take(at(t[k]), t[k == 2 ? 0 : k + 1]);
      }
    };
    each_edge([&](std::size_t from, int) { ++first_[from + 1]; });
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    neighbours_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    each_edge([&](std::size_t from, int to) { neighbours_[next[from]++] = to; });
  }

  // A facet whose q·y is large at all corners of a triangle, and the least of these. The search starts where the last
  // one ended.
  std::pair<std::size_t, double> nearest(const std::array<Vec3, 3>& corners) {
    const Vec3 sum = corners[0] + corners[1] + corners[2];
    climb([&](Vec3 q) { return dot(q, sum); });
    const double height =
        climb([&](Vec3 q) { return smaller(dot(q, corners[0]), smaller(dot(q, corners[1]), dot(q, corners[2]))); });
    return {here_, height};
  }

 private:
  const std::vector<Vec3>& points_;
  std::vector<std::size_t> first_;  // of each point, in `neighbours_`
  std::vector<std::int32_t> neighbours_;
  std::size_t here_ = 0;

  // To neighbours with a larger value, as long as there is one.
  template <class Value>
  double climb(Value value) {
    double best = value(points_[here_]);
    for (bool moves = true; moves;) {
      moves = false;
      const std::size_t from = here_;
      for (std::size_t k = first_[from]; k < first_[from + 1]; ++k) {
        const std::size_t there = at(neighbours_[k]);
        const double found = value(points_[there]);
        if (found > best) best = found, here_ = there, moves = true;
      }
    }
    return best;
  }
};

// Whether the solid surely winds around some point that is in the hull shrunk by the deepest dent. The ray from one
// point alone may meet an edge, above all from the middle of a symmetric body.
bool winds_around_middle(const Polytope& hull, const Solid& solid) {
  constexpr std::array<Vec3, 3> kOffsets{Vec3{0, 0, 0}, Vec3{0.31, 0.17, -0.11}, Vec3{-0.13, 0.29, 0.23}};
  const double inner_radius = (1 - kDeepestDent) / hull.polar_radius;
  for (const Vec3 offset : kOffsets) {
    const Vec3 point = hull.centre + inner_radius * offset;
    if (norm(point - hull.centre) < inner_radius && surely_winds_around(solid, point)) return true;
  }
  return false;
}

// The facets with the deepest dents by name, the other ones by their deepest.
HullDents sorted_dents(const std::vector<double>& depths) {
  std::vector<std::int32_t> order(depths.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return depths[at(a)] > depths[at(b)]; });
  HullDents dents;
  dents.deepest = depths[at(order.front())];
  for (const std::int32_t facet : order) {
    dents.others = depths[at(facet)];
    if (dents.facets.size() == kNamedFacets || dents.others < kShallow) break;
    dents.facets.push_back({facet, 1 - dents.others});
  }
  return dents;
}

}  // namespace

HullDents dents_of(const Polytope& hull, const Solid& solid) {
  HullDents unknown;
  unknown.deepest = unknown.others = kUnknownDent;
  if (!solid.is_closed || !hull.has_polar()) return unknown;
  const double room = kDentError * hull.polar_radius * hull.radius;
  std::vector<double> depths(hull.polar.points.size(), room);
  FacetSearch facets(hull);
  for (const MeshTriangle& t : solid.triangles) {
    const auto corner = [&](std::size_t k) { return solid.points[at(t[k])] - hull.centre; };
    const auto [facet, height] = facets.nearest({corner(0), corner(1), corner(2)});
    depths[facet] = larger(depths[facet], 1 - height + room);
    if (!(depths[facet] < kDeepestDent)) return unknown;
  }
  return winds_around_middle(hull, solid) ? sorted_dents(depths) : unknown;
}

std::vector<double> facet_heights(const Polytope& body) {
  std::vector<double> heights(body.polar.points.size(), 1 - body.dents.others);
  for (const DentedFacet& dented : body.dents.facets) heights[at(dented.facet)] = dented.height;
  return heights;
}

double scale_past_dents(const Polytope& body, Vec3 y, double error) {
  double scale = 1 - body.dents.others;
  for (const DentedFacet& dented : body.dents.facets) {
    const double height = dot(body.polar.points[at(dented.facet)], y) + error;
    if (scale * height > dented.height) scale = dented.height / height;
  }
  return scale;
}

}  // namespace plannercheck
