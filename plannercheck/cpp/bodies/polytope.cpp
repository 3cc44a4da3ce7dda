#include "bodies/polytope.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "bodies/flat_hull.hpp"
#include "math/box.hpp"
#include "math/double_double.hpp"
#include "math/dyadic.hpp"
#include "math/predicates.hpp"

namespace plannercheck {
namespace {

// n / (n · (a − centre)) for the plane through a, b, c: in double-double where its error stays below 2^-60, else exact.
Vec3 polar_point(Vec3 centre, Vec3 a, Vec3 b, Vec3 c) {
  const DoubleDoubleVec3 n = cross(difference(b, a), difference(c, a));
  const DoubleDouble height = dot(n, difference(a, centre));
  const double size = norm_max(b - a) * norm_max(c - a);
  const double length = larger(std::fabs(n.x.high), larger(std::fabs(n.y.high), std::fabs(n.z.high)));
  const bool precise = size > 1e-150 && size < 1e60 && size * 0x1p-96 < length * 0x1p-62 &&
                       size * norm_max(a - centre) * 0x1p-94 < height.high * 0x1p-62;
  if (precise) return {n.x.high / height.high, n.y.high / height.high, n.z.high / height.high};
  const DyadicVec3 corner(a);
  const DyadicVec3 normal = cross(DyadicVec3(b) - corner, DyadicVec3(c) - corner);
  const Dyadic exact_height = dot(normal, corner - DyadicVec3(centre));
  const std::int64_t scale = -exact_height.log2();
  const double divisor = exact_height.to_double(scale);
  return {normal.x.to_double(scale) / divisor, normal.y.to_double(scale) / divisor,
          normal.z.to_double(scale) / divisor};
}

double squared_area(const ConvexMesh& mesh, const Triangle& t) {
  const Vec3 a = mesh.vertices[at(t[0])];
  const Vec3 n = cross(mesh.vertices[at(t[1])] - a, mesh.vertices[at(t[2])] - a);
  return dot(n, n);
}

// One polar point for each facet, from the facet's largest triangle.
std::vector<Vec3> polar_points(const ConvexMesh& mesh, Vec3 centre) {
  int count = 0;
  const std::vector<int> facet = facets(mesh, &count);
  std::vector<int> largest(at(count), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    int& best = largest[at(facet[t])];
    if (best < 0 || squared_area(mesh, mesh.triangles[t]) > squared_area(mesh, mesh.triangles[at(best)])) {
      best = static_cast<int>(t);
    }
  }
  std::vector<Vec3> points;
  for (const int t : largest) {
    const Triangle& v = mesh.triangles[at(t)];
    points.push_back(polar_point(centre, mesh.vertices[at(v[0])], mesh.vertices[at(v[1])], mesh.vertices[at(v[2])]));
  }
  return points;
}

double largest_norm(const std::vector<Vec3>& points, Vec3 from) {
  double largest = 0;
  for (const Vec3& p : points) largest = larger(largest, norm_above(p - from));
  return largest;
}

// `points`: the vertices, all different.
void enclose(Polytope& body, const std::vector<Vec3>& points) {
  const Box box = box_around(points);
  body.low = box.low, body.high = box.high;
  const auto at_corner = [&](const Vec3& p) {
    return (p.x == body.low.x || p.x == body.high.x) && (p.y == body.low.y || p.y == body.high.y) &&
           (p.z == body.low.z || p.z == body.high.z);
  };
  body.is_box = points.size() == 8 && std::all_of(points.begin(), points.end(), at_corner) ? 1 : 0;
}

// Adds the polar about a point strictly inside. Returns false and changes nothing if doubles cannot hold the polar: the
// body is thinner than their grid, or so small that its polar overflows.
bool add_polar(const ConvexMesh& mesh, Polytope& body) try {
  const std::optional<Vec3> inside = interior_point(mesh);
  if (!inside) return false;
  const std::vector<Vec3> points = polar_points(mesh, *inside);
  const double radius = largest_norm(points, {});
  if (!(radius < 1 / kTrustedLength)) return false;
  const ConvexMesh polar = convex_hull(points);
  body.centre = *inside;
  body.polar_radius = radius;
  body.polar_triangles = polar.triangles;
  body.polar = build_hierarchy(polar);
  return true;
} catch (const HullError&) {
  return false;
}

// Without a polar the centre serves only as a guess and for bounds, so the rounded mean of the vertices is enough.
void do_without_polar(Polytope& body) {
  const std::vector<Vec3>& vertices = body.inner.points;
  const double weight = 1 / static_cast<double>(vertices.size());
  body.centre = {};
  for (const Vec3& v : vertices) body.centre = body.centre + weight * v;
  body.polar_radius = std::numeric_limits<double>::infinity();
}

void measure(Polytope& body) {
  body.origin_radius = largest_norm(body.inner.points, {});
  body.radius = largest_norm(body.inner.points, body.centre);
  enclose(body, body.inner.points);
}

}  // namespace

Polytope prepare_polytope(const ConvexMesh& mesh) {
  Polytope body;
  body.triangles = mesh.triangles;
  body.source = mesh.source;
  body.inner = build_hierarchy(mesh);
  facets(mesh, &body.facet_count);
  if (!add_polar(mesh, body)) do_without_polar(body);
  measure(body);
  body.ellipsoid = equivalent_ellipsoid(body.inner.points, body.triangles);
  return body;
}

Polytope with_solid(const Polytope& hull, std::shared_ptr<const Solid> solid) {
  Polytope body = hull;
  body.dents = dents_of(hull, *solid);
  body.shape = std::move(solid);
  body.is_box = 0;
  body.lazy_inner_shapes = {}, body.lazy_surface = {};
  return body;
}

Polytope polytope_around(std::shared_ptr<const PartSet> parts, double inflation_radius) {
  // Radii are lengths of the world, and poses may shrink the box.
  const double more = parts->largest_radius() * (kRadiusStretch - 1);
  Polytope body = prepare_polytope(parts->box().grown(more).corners());
  body.inflation_radius = inflation_radius;
  body.is_box = 0;
  body.dents.deepest = kUnknownDent;
  body.shape = std::move(parts);
  return body;
}

Polytope prepare_polytope(const std::vector<Vec3>& points) {
  const AffineSpan span = affine_span(points);
  if (span.dimension == 3) return prepare_polytope(convex_hull(points));
  const FlatHull hull = flat_hull(points, span);
  Polytope body;
  body.dimension = hull.dimension;
  body.source = hull.source;
  body.inner = build_flat_hierarchy(hull);
  do_without_polar(body);
  measure(body);
  return body;
}

namespace {

// Every vertex of a flat body has to be a corner: strictly further out than its neighbours allow.
std::string flat_fault(const Polytope& body) {
  const FlatHull again = flat_hull(body.inner.points, affine_span(body.inner.points));
  if (again.dimension != body.dimension) return "the dimension is wrong";
  if (again.vertices.size() != body.inner.points.size()) return "a vertex is no corner";
  for (const Levels* h : {static_cast<const Levels*>(&body.inner), &body.inner.top_levels}) {
    std::size_t chained = 0;
    for (const ChainRange& chain : h->chains) chained += at(chain.length);
    const auto removed = std::count_if(h->level.begin(), h->level.end(), [&](auto l) { return l < h->depth; });
    if (chained != 2 * static_cast<std::size_t>(removed)) return "the chains are incomplete";
  }
  return {};
}

}  // namespace

std::string polytope_fault(const Polytope& body) try {
  if (body.dimension < 3) return flat_fault(body);
  const ConvexMesh hull = verified_hull(body.inner.points, body.triangles, &body.centre);
  const std::string inner = hierarchy_fault(hull, body.inner);
  if (!inner.empty()) return "hull: " + inner;
  if (!body.has_polar()) return {};
  const Vec3 origin;
  const ConvexMesh dual = verified_hull(body.polar.points, body.polar_triangles, &origin);
  const std::string polar = hierarchy_fault(dual, body.polar);
  if (!polar.empty()) return "polar: " + polar;
  for (const Triangle& t : body.triangles) {
    const auto& p = body.inner.points;
    if (orientation(p[at(t[0])], p[at(t[1])], p[at(t[2])], body.centre) >= 0)
      return "the centre is not strictly inside";
  }
  return {};
} catch (const HullError& error) {
  return error.what();
}

std::size_t Polytope::bytes() const {
  return sizeof *this + triangles.size() * sizeof(Triangle) + source.size() * sizeof(source[0]) + inner.bytes() +
         inner.top_levels.bytes() + polar.bytes() + polar.top_levels.bytes() +
         polar_triangles.size() * sizeof(Triangle);
}

}  // namespace plannercheck
