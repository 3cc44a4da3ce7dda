#include "narrow_phase/shared_point.hpp"

#include <cmath>
#include <optional>

#include "bodies/half_space.hpp"
#include "bodies/part_body.hpp"
#include "narrow_phase/pair_kernels.hpp"

namespace plannercheck {
namespace {

Vec3 nearest_point(const DyadicVec3& sum, const Dyadic& by) {
  return {nearest_quotient(sum.x, by), nearest_quotient(sum.y, by), nearest_quotient(sum.z, by)};
}

Vec3 of_hulls(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters) {
  const bool swapped = choose_b(*a.body, *b.body) == 0;
  const PosedPolytope &body_a = swapped ? b : a, &body_b = swapped ? a : b;
  const ExactAnswer found = exact_contact(body_a, body_b, test_pair(body_a, body_b, {}, nullptr, counters), counters);
  DyadicVec3 on_a, on_b;
  Dyadic total;
  for (std::size_t i = 0; i < static_cast<std::size_t>(found.count); ++i) {
    const auto posed = [](const PosedPolytope& posed, std::int32_t v) {
      return apply_exactly(posed.pose, posed.body->inner.points[at(v)]);
    };
    total = total + found.weight[i];
    on_a = on_a + found.weight[i] * posed(body_a, found.body_a[i]);
    on_b = on_b + found.weight[i] * posed(body_b, found.body_b[i]);
  }
  const Dyadic radius_a(body_a.body->inflation_radius), radius_b(body_b.body->inflation_radius);
  const Dyadic radii = radius_a + radius_b;
  if (radii.sign() == 0) return nearest_point(on_a, total);
  return nearest_point(radius_b * on_a + radius_a * on_b, radii * total);
}

Polytope triangle_of(const Polytope& body, std::int32_t triangle) {
  const Solid& surface = body.surface();
  PartShape shape;
  for (const std::int32_t corner : surface.triangles[at(triangle)])
    shape.corner[shape.corners++] = surface.points[at(corner)];
  return polytope_of(shape, body.inflation_radius);
}

Vec3 of_vertex(const PosedPolytope& inner, std::int32_t vertex) {
  const Polytope& body = *inner.body;
  const Vec3 point = body.traits().fills_hull() ? body.inner.points[0] : body.surface().points[at(vertex)];
  return nearest_point(apply_exactly(inner.pose, point), Dyadic(1.0));
}

// For a body that is no set: its deepest vertex, or a point between that vertex and the plane.
Vec3 of_half_space(const PosedPolytope& half_space, const PosedPolytope& body) {
  const auto plane = posed_plane<Dyadic, DyadicVec3>(half_space.body->as<HalfSpace>(), half_space.pose);
  const DyadicVec3 shift(half_space.pose.translation());
  std::optional<Dyadic> least;
  DyadicVec3 deepest;
  for (const Vec3& p : body.body->inner.points) {
    const DyadicVec3 place = apply_exactly(body.pose, p);
    const Dyadic height = dot(plane.normal, place - shift) - plane.offset;
    if (!least || (height - *least).sign() < 0) least = height, deepest = place;
  }
  const Dyadic radius(body.body->inflation_radius), radii = radius + Dyadic(half_space.body->inflation_radius);
  if (least->sign() <= 0 || radii.sign() == 0) return nearest_point(deepest, Dyadic(1.0));
  const Dyadic by = dot(plane.normal, plane.normal) * radii;
  return nearest_point(by * deepest - (*least * radius) * plane.normal, by);
}

// The part of a set, or the body itself.
Polytope part_of(const Polytope& body, std::int32_t place) {
  return place < 0 ? body : polytope_of(body.as<PartSet>().shape(at(place)), body.inflation_radius);
}

}  // namespace

ExactAnswer exact_contact(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairVerdict& verdict,
                          PairCounters& counters) {
  if (verdict.exact) return *verdict.exact;
  const Vec3 apart = body_a.pose.apply(body_a.body->centre) - body_b.pose.apply(body_b.body->centre);
  return decide_exactly(body_a, body_b, nearest_points(body_a, body_b, apart, counters));
}

Vec3 shared_point(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters) {
  const Sets sets = sets_of(*a.body, *b.body);
  const Kind kind = kind_of(*a.body, *b.body);
  if (kind == Kind::kHull) return of_hulls(a, b, counters);
  if (kind == Kind::kHalfSpace && !sets.first && !sets.second)
    return a.body->traits().is_bounded ? of_half_space(b, a) : of_half_space(a, b);
  const SolidContact met = contact(a, b, {}, counters);
  if (met.kind == SolidContact::Kind::kAInB) return of_vertex(a, met.a);
  if (met.kind == SolidContact::Kind::kBInA) return of_vertex(b, met.b);
  const bool triangles = met.kind == SolidContact::Kind::kTriangles;
  const Polytope of_a = triangles ? triangle_of(*a.body, met.a) : part_of(*a.body, met.a);
  const Polytope of_b = triangles ? triangle_of(*b.body, met.b) : part_of(*b.body, met.b);
  const PosedPolytope part_a{&of_a, a.pose}, part_b{&of_b, b.pose};
  return triangles ? of_hulls(part_a, part_b, counters) : shared_point(part_a, part_b, counters);
}

}  // namespace plannercheck
