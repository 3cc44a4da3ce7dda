// A body prepared for queries: its hull, the hierarchy of the hull, and the hierarchy of its polar.
//
// The polar has its origin at `centre`: the facet n·(x − centre) = h becomes the point n / h, so the body is {x : q·(x
// − centre) <= 1 for all polar points q}. Exactly coplanar triangles are merged first: a cube has six polar points.
// Polar points are rounded; each errs by at most kPolarError of its length. Bodies without volume (polygons, segments,
// points) have no polar. Any body may be inflated to all points within `inflation_radius` of its hull: points become
// spheres, segments capsules.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "bodies/covering_balls.hpp"
#include "bodies/equivalent_ellipsoid.hpp"
#include "bodies/hierarchy.hpp"
#include "bodies/hull.hpp"
#include "bodies/hull_dents.hpp"
#include "bodies/inner_shapes.hpp"
#include "bodies/lazy_value.hpp"
#include "bodies/part_set.hpp"
#include "bodies/small_ball.hpp"
#include "bodies/solid.hpp"

namespace plannercheck {

// Numerator and denominator are each rounded once (and err by 2^-60 before), then divided: a little over 3u.
inline constexpr double kPolarError = 4 * 0x1p-53;

// Raise it with any change to the fields of Polytope or Hierarchy, their order or meaning: old files are then refused.
inline constexpr int kPolytopeFormat = 11;

struct HalfSpace;

// What a body is. A KindTable has a row for each kind of pair: the later kind of both bodies.
enum class Kind : std::uint8_t { kHull, kSolid, kPartSet, kHalfSpace };
template <class Row>
class KindTable {
 public:
  constexpr KindTable(Row hulls, Row solids, Row part_sets, Row half_spaces)
      : rows_{hulls, solids, part_sets, half_spaces} {}
  constexpr const Row& operator[](Kind of_pair) const { return rows_[static_cast<std::size_t>(of_pair)]; }

 private:
  std::array<Row, 4> rows_;
};

// What follows from a body's kind: all that filters and searches ask for.
struct KindTraits {
  bool is_convex, is_bounded;
  bool has_parts;  // tested one by one; the hull is only a box around them

  bool fills_hull() const { return is_convex && is_bounded; }
};
inline constexpr KindTable<KindTraits> kKindTraits{
    {true, true, false}, {false, true, false}, {false, true, true}, {true, false, false}};

struct Polytope {
  std::int32_t dimension = 3;        // of the hull: 0 point, 1 segment, 2 polygon, 3
  double inflation_radius = 0;       // m
  std::vector<Triangle> triangles;   // of the hull, outward; indices into inner.points
  std::vector<std::int32_t> source;  // per vertex: index into the points that were given
  Vec3 centre;                       // strictly inside; without a polar the mean of the vertices, rounded
  double origin_radius = 0;          // largest |v|, distance from the frame's origin, over the vertices, rounded up
  double radius = 0;                 // largest |v − centre|, rounded up
  Vec3 low, high;                    // the box around the vertices, in the body's frame
  std::int32_t is_box = 0;           // 1 if the body is that box, and no solid
  Hierarchy inner;
  Hierarchy polar;
  std::vector<Triangle> polar_triangles;  // of the hull of the polar points, outward
  double polar_radius = 0;                // largest |q| over the polar points, rounded up
  std::int32_t facet_count = 0;
  EquivalentEllipsoid ellipsoid;             // not in files
  LazyValue<InnerShapes> lazy_inner_shapes;  // only checkers of configurations need these two
  LazyValue<SmallBall> lazy_small_ball;
  LazyValue<std::vector<SmallBall>> lazy_covering_balls;  // only motions before sets of parts need them
  LazyValue<std::vector<SmallBall>> lazy_few_covering_balls;
  LazyValue<Solid> lazy_surface;  // only tests with solids need it
  HullDents dents;                // of a solid or a set; not in files
  // By kind: nothing more than the hull; a solid, whose hull is all above; a set of parts, for which all above is a box
  // around it; a half-space, for which all above is a cube that holds everything. Not in files.
  std::variant<std::monostate, std::shared_ptr<const Solid>, std::shared_ptr<const PartSet>,
               std::shared_ptr<const HalfSpace>>
      shape;

  Kind kind() const { return static_cast<Kind>(shape.index()); }
  const KindTraits& traits() const { return kKindTraits[kind()]; }
  // The shape of a body of this kind.
  template <class Shape>
  const Shape& as() const {
    return **std::get_if<std::shared_ptr<const Shape>>(&shape);
  }

  const InnerShapes& inner_shapes() const {
    return lazy_inner_shapes.get([this] { return find_inner_shapes(*this); });
  }
  // A ball around the hull, without the inflation radius.
  const SmallBall& small_ball() const {
    return lazy_small_ball.get([this] { return plannercheck::small_ball(inner.points, 0.5 * (low + high)); });
  }
  // Several balls that hold the hull together.
  const std::vector<SmallBall>& covering_balls() const {
    return lazy_covering_balls.get([this] { return plannercheck::covering_balls(*this); });
  }
  // Two or three such balls at most.
  const std::vector<SmallBall>& few_covering_balls() const {
    return lazy_few_covering_balls.get([this] { return plannercheck::few_covering_balls(*this); });
  }
  // The solid, or the hull as one; without the inflation radius.
  const Solid& surface() const {
    const auto* const solid = std::get_if<std::shared_ptr<const Solid>>(&shape);
    return solid != nullptr ? **solid : lazy_surface.get([this] { return surface_of(*this); });
  }

  // False for bodies without volume, and for those thinner than the grid of doubles.
  bool has_polar() const { return !polar.points.empty(); }
  std::size_t bytes() const;
};

// Which bodies of a pair are sets of parts.
struct Sets {
  bool first, second;

  bool is_one() const { return first != second; }
  bool are_both() const { return first && second; }
};
inline Sets sets_of(const Polytope& a, const Polytope& b) { return {a.traits().has_parts, b.traits().has_parts}; }

// The kind of a pair.
inline Kind kind_of(const Polytope& a, const Polytope& b) { return std::max(a.kind(), b.kind()); }

Polytope prepare_polytope(const ConvexMesh& mesh);

// A solid as a body, from the prepared body of its hull.
Polytope with_solid(const Polytope& hull, std::shared_ptr<const Solid> solid);

// A set of parts as a body, with an inflation radius.
Polytope polytope_around(std::shared_ptr<const PartSet> parts, double inflation_radius);

// Prepares the hull of the points, of any dimension; there is at least one point.
Polytope prepare_polytope(const std::vector<Vec3>& points);

// Describes the first broken property, empty if there is none: hull and polar convex, hierarchies sound.
std::string polytope_fault(const Polytope& body);

// The body as bytes, without pointers. `parse_polytope` throws HullError if the bytes are no such body.
std::string serialise(const Polytope& body);
Polytope parse_polytope(const char* data, std::size_t size);

}  // namespace plannercheck
