#include "bodies/hull_dents.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "bodies/polytope.hpp"
#include "bodies/solid.hpp"
#include "bodies/solid_interior.hpp"

namespace plannercheck {
namespace {

// Solids with deeper dents are better known by the balls and boxes inside of them.
constexpr double kDeepestDent = 1.0 / 16;

// Of q·y, in parts of the largest |q| times the largest |y|: polar points err by 4u, y by 1u, the product by 3u, and
// the difference from 1 and the sum with this bound by 1u each of at most 2.
constexpr double kDentError = 32 * 0x1p-53;

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

  // The least q·y over a triangle's corners, of a polar point q for which that is large. The search starts where the
  // last one ended.
  double height_of(const std::array<Vec3, 3>& corners) {
    const Vec3 sum = corners[0] + corners[1] + corners[2];
    climb([&](Vec3 q) { return dot(q, sum); });
    return climb([&](Vec3 q) { return smaller(dot(q, corners[0]), smaller(dot(q, corners[1]), dot(q, corners[2]))); });
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

}  // namespace

double dent_of(const Polytope& hull, const Solid& solid) {
  if (!solid.is_closed || !hull.has_polar()) return kUnknownDent;
  const double room = kDentError * hull.polar_radius * hull.radius;
  FacetSearch facets(hull);
  double least = 1;
  for (const MeshTriangle& t : solid.triangles) {
    const auto corner = [&](std::size_t k) { return solid.points[at(t[k])] - hull.centre; };
    least = smaller(least, facets.height_of({corner(0), corner(1), corner(2)}));
    if (!(1 - least + room < kDeepestDent)) return kUnknownDent;
  }
  return winds_around_middle(hull, solid) ? 1 - least + room : kUnknownDent;
}

}  // namespace plannercheck
