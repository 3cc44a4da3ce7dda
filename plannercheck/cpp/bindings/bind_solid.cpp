// Solids in Python: what is prepared of a mesh, and what two of them share.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <memory>
#include <string>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "bodies/hull.hpp"
#include "bodies/polytope.hpp"
#include "bodies/solid.hpp"
#include "narrow_phase/solid_pair.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

std::shared_ptr<Solid> solid_from(InputArray<double, -1, 3> vertices, InputArray<std::int32_t, -1, 3> triangles) {
  std::vector<Vec3> points(vertices.shape(0));
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = {vertices(i, 0), vertices(i, 1), vertices(i, 2)};
  std::vector<MeshTriangle> corners(triangles.shape(0));
  for (std::size_t t = 0; t < corners.size(); ++t) corners[t] = {triangles(t, 0), triangles(t, 1), triangles(t, 2)};
  std::shared_ptr<Solid> solid;
  without_gil([&] { solid = std::make_shared<Solid>(prepare_solid(points, corners)); });
  return solid;
}

// Whether a point in the solid's frame is on a triangle or wound around, exactly.
bool contains(const Solid& solid, InputArray<double, 3> point) {
  const std::vector<Vec3> points{{point(0), point(1), point(2)}};
  const Polytope of_solid = with_solid(Polytope{}, std::make_shared<Solid>(solid));
  const Polytope of_point = prepare_polytope(points);
  PairCounters counters;
  return static_cast<bool>(solids_contact({&of_point, {}}, {&of_solid, {}}, {}, counters));
}

auto solid_points(const Solid& solid) {
  std::vector<double> flat;
  for (const Vec3& p : solid.points) flat.insert(flat.end(), {p.x, p.y, p.z});
  return output_array(flat, {solid.points.size(), std::size_t{3}});
}

// In the order in which they were given.
auto solid_triangles(const Solid& solid) {
  std::vector<std::int32_t> flat(3 * solid.triangles.size());
  for (std::size_t k = 0; k < solid.triangles.size(); ++k)
    std::copy_n(solid.triangles[k].begin(), 3, flat.begin() + 3 * solid.source[k]);
  return output_array(flat, {solid.triangles.size(), std::size_t{3}});
}

// What two bodies share: "apart", "triangles" with their indices among those given, or "a in b" or "b in a" with a
// vertex of the inner one; and counts of boxes, triangle pairs, those decided exactly, and winding numbers.
nb::tuple contact_of(const Polytope& a, InputArray<double, 4, 4> pose_a, const Polytope& b,
                     InputArray<double, 4, 4> pose_b) {
  PairCounters counters;
  SolidCounters counted;
  const SolidContact found =
      solids_contact({&a, pose_from(pose_a.data())}, {&b, pose_from(pose_b.data())}, {}, counters, &counted);
  const nb::tuple counts = nb::make_tuple(counted.boxes, counted.triangles, counted.exact, counted.points);
  switch (found.kind) {
    case SolidContact::Kind::kTriangles:
      return nb::make_tuple("triangles", a.surface().source[at(found.a)], b.surface().source[at(found.b)], counts);
    case SolidContact::Kind::kAInB:
      return nb::make_tuple("a in b", found.a, -1, counts);
    case SolidContact::Kind::kBInA:
      return nb::make_tuple("b in a", -1, found.b, counts);
    case SolidContact::Kind::kNone:
      break;
  }
  return nb::make_tuple("apart", -1, -1, counts);
}

}  // namespace

void bind_solid(nb::module_& m) {
  nb::class_<Solid>(m, "Solid")
      .def(nb::new_(&solid_from), plain_floats)
      .def("points", &solid_points, plain_floats)
      .def("triangles", &solid_triangles, plain_floats)
      .def(
          "order", [](const Solid& s) { return output_array(s.source, {s.source.size()}); }, plain_floats)
      .def("contains", &contains, plain_floats)
      .def_ro("is_closed", &Solid::is_closed)
      .def_prop_ro("components", [](const Solid& s) { return s.components.size(); })
      .def_prop_ro("nbytes", &Solid::bytes);

  m.def("solids_contact", &contact_of, plain_floats);
}

}  // namespace plannercheck
