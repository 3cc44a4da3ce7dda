// Solids in Python: what is prepared of a mesh, and what two of them share.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "bodies/hull.hpp"
#include "bodies/polytope.hpp"
#include "bodies/solid.hpp"
#include "narrow_phase/pair_kernels.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

std::shared_ptr<Solid> solid_from(InputArray<double, -1, 3> vertices, InputArray<std::int32_t, -1, 3> triangles,
                                  bool own_axes) {
  const std::vector<Vec3> points = points_from(vertices);
  const std::vector<MeshTriangle> corners = triples_from(triangles);
  std::shared_ptr<Solid> solid;
  without_gil([&] { solid = std::make_shared<Solid>(prepare_solid(points, corners, own_axes)); });
  return solid;
}

// Whether a point in the solid's frame is on a triangle or wound around, exactly.
bool contains(const Solid& solid, InputArray<double, 3> point) {
  const std::vector<Vec3> points{{point(0), point(1), point(2)}};
  const Polytope of_solid = with_solid(Polytope{}, std::make_shared<Solid>(solid));
  const Polytope of_point = prepare_polytope(points);
  PairCounters counters;
  return static_cast<bool>(triangles_contact({&of_point, {}}, {&of_solid, {}}, {}, counters));
}

// In the order in which they were given.
auto solid_triangles(const Solid& solid) {
  std::vector<std::int32_t> flat(3 * solid.triangles.size());
  for (std::size_t k = 0; k < solid.triangles.size(); ++k)
    std::copy_n(solid.triangles[k].begin(), 3, flat.begin() + 3 * solid.source[k]);
  return output_array(flat, {solid.triangles.size(), std::size_t{3}});
}

// A box's row: middle, three axes, half extents.
void put_row(const OrientedBox& box, std::vector<double>& rows) {
  const auto put = [&](const std::array<float, 3>& v) { rows.insert(rows.end(), v.begin(), v.end()); };
  put(box.centre);
  for (const auto& axis : box.axis) put(axis);
  put(box.half);
}

// The range of triangles below a node; the boxes below it, and their ranges, are added.
std::array<std::int32_t, 2> put_boxes(const TriangleTree& tree, std::int32_t child, std::vector<double>& rows,
                                      std::vector<std::int32_t>& ranges) {
  if (child < 0) return {~child, ~child + 1};
  const TriangleNode& node = tree.nodes[at(child)];
  std::array<std::int32_t, 2> all{};
  for (std::size_t k = 0; k < node.children; ++k) {
    const auto range = put_boxes(tree, node.child(k), rows, ranges);
    put_row(node.box(k), rows);
    ranges.insert(ranges.end(), range.begin(), range.end());
    all = {k == 0 ? range[0] : all[0], range[1]};
  }
  return all;
}

// The tree's units and middle (4); its boxes (k, 15) in those units; and the triangles in them (k, 2), from the first
// up to the last, the last one excluded.
nb::tuple boxes_of(const Solid& solid) {
  const TriangleTree& tree = solid.tree;
  std::vector<double> rows;
  std::vector<std::int32_t> ranges;
  const auto range = put_boxes(tree, 0, rows, ranges);
  put_row(tree.root, rows);
  ranges.insert(ranges.end(), range.begin(), range.end());
  const std::vector<double> frame{tree.units, tree.middle.x, tree.middle.y, tree.middle.z};
  return nb::make_tuple(output_array(frame, {std::size_t{4}}), output_array(rows, {rows.size() / 15, std::size_t{15}}),
                        output_array(ranges, {ranges.size() / 2, std::size_t{2}}));
}

// What two bodies share: "apart", "triangles" with their indices among those given, "parts" or "half-space" with the
// places of parts (−1: no set), or "a in b" or "b in a" with a vertex of the inner one; and counts of boxes, triangle
// pairs, those decided exactly, and winding numbers.
nb::tuple contact_of(const Polytope& a, InputArray<double, 4, 4> pose_a, const Polytope& b,
                     InputArray<double, 4, 4> pose_b, bool boxes, bool nearest_first, bool lanes, bool reaching_out) {
  PairCounters counters;
  SolidCounters counted;
  const SolidOptions options{boxes, nearest_first, lanes, reaching_out};
  const PosedPolytope posed_a{&a, pose_from(pose_a.data())}, posed_b{&b, pose_from(pose_b.data())};
  const SolidContact found = contact(posed_a, posed_b, {}, counters, options, &counted);
  const nb::tuple counts = nb::make_tuple(counted.boxes, counted.triangles, counted.exact, counted.points);
  switch (found.kind) {
    case SolidContact::Kind::kTriangles:
      return nb::make_tuple("triangles", a.surface().source[at(found.a)], b.surface().source[at(found.b)], counts);
    case SolidContact::Kind::kAInB:
      return nb::make_tuple("a in b", found.a, -1, counts);
    case SolidContact::Kind::kBInA:
      return nb::make_tuple("b in a", -1, found.b, counts);
    case SolidContact::Kind::kParts:
      return nb::make_tuple("parts", found.a, found.b, counts);
    case SolidContact::Kind::kHalfSpace:
      return nb::make_tuple("half-space", found.a, found.b, counts);
    case SolidContact::Kind::kNone:
      break;
  }
  return nb::make_tuple("apart", -1, -1, counts);
}

}  // namespace

void bind_solid(nb::module_& m) {
  nb::class_<Solid>(m, "Solid")
      .def(nb::new_(&solid_from), nb::arg("vertices"), nb::arg("triangles"), nb::arg("own_axes") = true, plain_floats)
      .def(
          "points", [](const Solid& s) { return point_array(s.points); }, plain_floats)
      .def("triangles", &solid_triangles, plain_floats)
      .def(
          "order", [](const Solid& s) { return output_array(s.source, {s.source.size()}); }, plain_floats)
      .def("contains", &contains, plain_floats)
      .def("boxes", &boxes_of, plain_floats)
      .def_ro("is_closed", &Solid::is_closed)
      .def_prop_ro("components", [](const Solid& s) { return s.components.size(); })
      .def_prop_ro("nbytes", &Solid::bytes);

  m.def("solids_contact", &contact_of, nb::arg("a"), nb::arg("pose_a"), nb::arg("b"), nb::arg("pose_b"),
        nb::arg("boxes") = true, nb::arg("nearest_first") = true, nb::arg("lanes") = true,
        nb::arg("reaching_out") = true, plain_floats);
}

}  // namespace plannercheck
