// Sets of parts in Python: clouds of balls, cells of lattices, and heights.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>

#include <array>
#include <memory>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "bodies/part_set.hpp"
#include "bodies/polytope.hpp"
#include "broad_phase/clearances_at.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

template <class Make>
std::shared_ptr<PartSet> part_set(Make make) {
  std::shared_ptr<PartSet> set;
  without_gil([&] { set = std::make_shared<PartSet>(make()); });
  return set;
}

std::shared_ptr<PartSet> balls(InputArray<double, -1, 3> points, InputArray<double, -1> radii) {
  const bool one = radii.shape(0) == 1;
  if (!one && radii.shape(0) != points.shape(0)) throw nb::value_error("radii: one, or one a point");
  return part_set([&] { return PartSet::balls(points.data(), points.shape(0), radii.data(), one); });
}

std::shared_ptr<PartSet> cells(InputArray<std::int32_t, -1, 3> keys, InputArray<std::int32_t, -1> sizes,
                               double resolution, InputArray<double, 3> origin) {
  if (sizes.shape(0) != keys.shape(0)) throw nb::value_error("sizes: one a key");
  const Vec3 from{origin(0), origin(1), origin(2)};
  return part_set([&] { return PartSet::cells(keys.data(), sizes.data(), keys.shape(0), resolution, from); });
}

std::shared_ptr<PartSet> columns(InputArray<double, -1, -1> heights, InputArray<double, 2> step,
                                 InputArray<double, 2> origin, double base) {
  const std::array<double, 2> steps{step(0), step(1)}, from{origin(0), origin(1)};
  return part_set(
      [&] { return PartSet::columns(heights.data(), heights.shape(0), heights.shape(1), steps, from, base); });
}

// The corners (n, 3) and the radius of the part at a place, and what it was given as; no corners where there is none.
nb::tuple part_at(const PartSet& set, std::size_t place) {
  if (place >= set.leaf_count() * kPartsInLeaf) throw nb::index_error("no such part");
  const PartShape part = set.shape(place);
  const std::vector<Vec3> corners(part.corner.begin(), part.corner.begin() + static_cast<std::ptrdiff_t>(part.corners));
  const std::int64_t source = part.corners == 0 ? -1 : set.source(place);
  return nb::make_tuple(point_array(corners), part.radius, source);
}

// The maker of the set, by its name, and its arguments.
nb::tuple state_of(const PartSet& set) {
  const PartSet::Given given = set.given();
  const std::size_t three = 3;
  switch (set.kind()) {
    case PartSet::Kind::kBalls:
      return nb::make_tuple("balls", nb::make_tuple(output_array(given.numbers, {set.part_count(), three}),
                                                    output_array(given.radii, {given.radii.size()})));
    case PartSet::Kind::kCells:
      return nb::make_tuple("cells", nb::make_tuple(output_array(given.keys, {set.part_count(), three}),
                                                    output_array(given.sizes, {set.part_count()}), given.resolution,
                                                    point_array(given.origin)));
    default:
      return nb::make_tuple(
          "columns", nb::make_tuple(output_array(given.numbers, {given.rows, given.columns}),
                                    output_array(std::vector<double>{given.step[0], given.step[1]}, {std::size_t{2}}),
                                    output_array(std::vector<double>{given.origin.x, given.origin.y}, {std::size_t{2}}),
                                    given.base));
  }
}

std::shared_ptr<Polytope> body_of(std::shared_ptr<PartSet> set, double inflation_radius) {
  return std::make_shared<Polytope>(polytope_around(std::move(set), inflation_radius));
}

auto clearances_of(const PartSet& set, InputArray<double, 4, 4> pose, double reach, InputArray<double, -1, 3> points) {
  const auto found = clearances_at(set, pose_from(pose.data()), reach, points.data(), points.shape(0));
  return output_array(found, {found.size() / 2, std::size_t{2}});
}

}  // namespace

void bind_part_set(nb::module_& m) {
  nb::register_exception_translator([](const std::exception_ptr& p, void*) {
    try {
      std::rethrow_exception(p);
    } catch (const PartSetError& e) {
      PyErr_SetString(PyExc_ValueError, e.what());
    }
  });
  nb::class_<PartSet>(m, "PartSet")
      .def_static("balls", &balls, plain_floats)
      .def_static("cells", &cells, plain_floats)
      .def_static("columns", &columns, plain_floats)
      .def_prop_ro("count", &PartSet::part_count)
      .def_prop_ro("places", [](const PartSet& s) { return s.leaf_count() * kPartsInLeaf; })
      .def(
          "low", [](const PartSet& s) { return point_array(s.box().low); }, plain_floats)
      .def(
          "high", [](const PartSet& s) { return point_array(s.box().high); }, plain_floats)
      .def_prop_ro("nbytes", &PartSet::bytes)
      .def("state", &state_of, plain_floats)
      .def("part", &part_at, plain_floats)
      .def("body", &body_of, plain_floats);
  m.def("part_clearances", &clearances_of, plain_floats);
}

}  // namespace plannercheck
