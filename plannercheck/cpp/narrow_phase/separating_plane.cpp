#include "narrow_phase/separating_plane.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "bodies/half_space.hpp"
#include "math/box.hpp"
#include "narrow_phase/intersection.hpp"
#include "narrow_phase/support_exact_direction.hpp"

namespace plannercheck {
namespace {

// As plannercheck/bodies has them: bits of a normal's length (exact_planes.py), and up to how many parts a plane is
// sought before the hull of their corners (part_certificates.py).
constexpr std::int64_t kLengthBits = 64;
constexpr std::size_t kMostInHull = 64;

Dyadic power_of_two(std::int64_t exponent) {
  constexpr std::int64_t kLimb = 64;
  const std::int64_t limbs = exponent >= 0 ? exponent / kLimb : -((-exponent + kLimb - 1) / kLimb);
  return Dyadic(std::ldexp(1.0, static_cast<int>(exponent - kLimb * limbs))).shifted_by_limbs(limbs);
}

// The least multiple of a power of two that is no less than the root of a positive number (root_above of
// plannercheck/common/exact_numbers.py).
Dyadic root_above(const Dyadic& square, std::int64_t bits) {
  const std::int64_t half = square.log2() >> 1, last = -std::max<std::int64_t>(0, bits - half);
  Dyadic below;  // the largest multiple whose square is less
  for (std::int64_t exponent = half + 1; exponent >= last; --exponent) {
    const Dyadic more = below + power_of_two(exponent);
    if ((more * more - square).sign() < 0) below = more;
  }
  return below + power_of_two(last);
}

// The least product of a direction with a point of a hull, the radius left out.
Dyadic lowest(const PosedPolytope& posed, const DyadicVec3& direction) {
  const FineDirection against(-rotate_back_exactly(posed.pose, direction));
  const std::int32_t vertex = extreme(posed.body->inner, against);
  return dot(direction, apply_exactly(posed.pose, posed.body->inner.points[at(vertex)]));
}

// How far along a direction from B to A both bodies reach, their radii left out.
struct Extents {
  Dyadic low_a, high_b;
};

std::optional<SeparatingPlane> plane_between(const DyadicVec3& direction, const Extents& reach, double radius_a,
                                             double radius_b) {
  const Dyadic apart = reach.low_a - reach.high_b, radii = Dyadic(radius_a) + Dyadic(radius_b),
               square = dot(direction, direction);
  if (apart.sign() <= 0 || (apart * apart - radii * radii * square).sign() <= 0) return std::nullopt;
  std::int64_t bits = kLengthBits;
  Dyadic length = root_above(square, bits);
  while ((apart - radii * length).sign() <= 0) length = root_above(square, bits *= 2);
  SeparatingPlane out;
  out.normal = {nearest_quotient(direction.x, length), nearest_quotient(direction.y, length),
                nearest_quotient(direction.z, length)};
  out.offset = nearest_quotient(reach.low_a + reach.high_b + (Dyadic(radius_b) - Dyadic(radius_a)) * length,
                                Dyadic(2.0) * length);
  const Dyadic over = apart - radii * length;
  out.gap = nearest_quotient(over, length);
  if ((Dyadic(out.gap) * length - over).sign() > 0) out.gap = std::nextafter(out.gap, 0.0);
  return out;
}

std::optional<SeparatingPlane> plane_along(const DyadicVec3& direction, const PosedPolytope& a,
                                           const PosedPolytope& b) {
  const Extents reach{lowest(a, direction), -lowest(b, -direction)};
  return plane_between(direction, reach, a.body->inflation_radius, b.body->inflation_radius);
}

// Brought to unit length in doubles.
DyadicVec3 unit_direction(Vec3 v) {
  const double largest = norm_max(v);
  const Vec3 scaled{v.x / largest, v.y / largest, v.z / largest};
  const double length = norm(scaled);
  return DyadicVec3(Vec3{scaled.x / length, scaled.y / length, scaled.z / length});
}

// Along what a verdict of hulls that are apart has found: up to rounding, then exactly. `sense`: −1 if its A is `b`.
std::optional<SeparatingPlane> plane_of(const PairVerdict& verdict, double sense, const PosedPolytope& frame,
                                        const PosedPolytope& a, const PosedPolytope& b) {
  const auto [found, exact] = direction_found(verdict, frame);
  std::optional<SeparatingPlane> plane;
  const double largest = norm_max(found);
  if (largest > 0 && std::isfinite(largest)) plane = plane_along(unit_direction(sense * found), a, b);
  if (!plane && exact) plane = plane_along(Dyadic(sense) * *exact, a, b);
  return plane;
}

// A filter's plane is rounded when it is mapped to the world, so close calls use the exact one.
std::optional<SeparatingPlane> plane_of_hulls(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters) {
  const bool swapped = choose_b(*a.body, *b.body) == 0;
  const PosedPolytope &body_a = swapped ? b : a, &body_b = swapped ? a : b;
  for (const Solver solver : {Solver::kDoubleOracle, Solver::kExact}) {
    PairOptions options;
    options.solver = solver;
    const PairVerdict verdict = test_pair(body_a, body_b, options, nullptr, counters);
    if (verdict.shared) return std::nullopt;
    if (auto plane = plane_of(verdict, swapped ? -1 : 1, body_b, a, b)) return plane;
  }
  return std::nullopt;
}

// Nothing else than the half-space's own plane can separate.
std::optional<SeparatingPlane> plane_over(const PosedPolytope& half_space, const PosedPolytope& body, bool is_first) {
  const auto plane = posed_plane<Dyadic, DyadicVec3>(half_space.body->as<HalfSpace>(), half_space.pose);
  const Dyadic height = plane.offset + dot(plane.normal, DyadicVec3(half_space.pose.translation()));
  const double radius = half_space.body->inflation_radius, other = body.body->inflation_radius;
  if (!is_first) return plane_between(plane.normal, {lowest(body, plane.normal), height}, other, radius);
  return plane_between(-plane.normal, {-height, -lowest(body, plane.normal)}, radius, other);
}

Polytope inflated_hull(const std::vector<Vec3>& points, double radius) {
  Polytope body = prepare_polytope(points);
  body.inflation_radius = radius;
  return body;
}

// The hull of a solid's corners, or of a hull's.
Polytope hull_of_surface(const Polytope& body) {
  const Solid& surface = body.surface();
  std::vector<bool> used(surface.points.size(), false);
  for (const auto& triangle : surface.triangles) {
    for (const std::int32_t corner : triangle) used[at(corner)] = true;
  }
  std::vector<Vec3> corners;
  for (std::size_t k = 0; k < used.size(); ++k) {
    if (used[k]) corners.push_back(surface.points[k]);
  }
  return inflated_hull(corners, body.inflation_radius);
}

// Around all parts of a set; none if it has no parts.
std::optional<Polytope> hull_of_parts(const Polytope& body) {
  std::vector<Vec3> corners;
  std::size_t count = 0;
  double radius = 0;
  body.as<PartSet>().any_part([&](const PartShape& shape, std::size_t) {
    corners.insert(corners.end(), shape.corner.begin(),
                   shape.corner.begin() + static_cast<std::ptrdiff_t>(shape.corners));
    radius = std::max(radius, shape.radius + body.inflation_radius), ++count;
    return false;
  });
  if (count == 0) return std::nullopt;
  if (count > kMostInHull) corners = box_around(corners).corners();
  const auto key = [](const Vec3& v) { return std::tuple(v.x, v.y, v.z); };
  std::stable_sort(corners.begin(), corners.end(), [&](const Vec3& u, const Vec3& v) { return key(u) < key(v); });
  const auto past =
      std::unique(corners.begin(), corners.end(), [&](const Vec3& u, const Vec3& v) { return key(u) == key(v); });
  corners.erase(past, corners.end());
  return inflated_hull(corners, radius);
}

std::optional<SeparatingPlane> plane_of_solids(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters) {
  const Polytope hull_a = hull_of_surface(*a.body), hull_b = hull_of_surface(*b.body);
  return plane_of_hulls({&hull_a, a.pose}, {&hull_b, b.pose}, counters);
}

std::optional<SeparatingPlane> plane_of_parts(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters) {
  const auto around = [](const PosedPolytope& posed) {
    return posed.body->traits().has_parts ? hull_of_parts(*posed.body) : std::optional<Polytope>(*posed.body);
  };
  const std::optional<Polytope> first = around(a), second = around(b);
  if (!first || !second) return std::nullopt;
  return separating_plane({&*first, a.pose}, {&*second, b.pose}, counters);
}

}  // namespace

std::optional<SeparatingPlane> separating_plane(const PosedPolytope& a, const PosedPolytope& b,
                                                PairCounters& counters) {
  const Sets sets = sets_of(*a.body, *b.body);
  if (sets.first || sets.second) return plane_of_parts(a, b, counters);
  switch (kind_of(*a.body, *b.body)) {
    case Kind::kHull:
      return plane_of_hulls(a, b, counters);
    case Kind::kSolid:
      return plane_of_solids(a, b, counters);
    default:
      return a.body->traits().is_bounded ? plane_over(b, a, false) : plane_over(a, b, true);
  }
}

}  // namespace plannercheck
