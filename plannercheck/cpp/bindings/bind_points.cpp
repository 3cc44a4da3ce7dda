// Points near posed bodies.
//
// In: bodies, their poses, and points with radii in a frame or in the world. Out: for each point whether some body is
// within its radius; or how far it is from each body.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "checking/points_near_bodies.hpp"
#include "narrow_phase/points_near_hull.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

// `xyz`: the three coordinates one after another.
auto near_hull(const Polytope& body, InputArray<double, 4, 4> pose, InputArray<double, 4, 4> frame,
               InputArray<double, 3, -1> xyz, InputArray<double, -1> radii, bool filters) {
  const std::size_t n = radii.shape(0);
  if (xyz.shape(1) != n) throw nb::value_error("there have to be as many radii as points");
  const double *const x = xyz.data(), *const y = x + n, *const z = y + n, *const r = radii.data();
  std::vector<std::uint8_t> near(n);
  PairCounters counters;
  PointsNearHull test({&body, pose_from(pose.data())}, pose_from(frame.data()), filters);
  for (std::size_t i = 0; i < n; i += kMostPoints) {
    const std::size_t count = std::min<std::size_t>(kMostPoints, n - i);
    const unsigned found = test.near(x + i, y + i, z + i, r + i, static_cast<int>(count), counters);
    for (std::size_t k = 0; k < count; ++k) near[i + k] = static_cast<std::uint8_t>(found >> k & 1U);
  }
  return nb::make_tuple(output_array(near, {n}), counters.rounds);
}

using Bodies = std::vector<std::shared_ptr<Polytope>>;

std::vector<PosedPolytope> posed(const Bodies& bodies, PoseRows poses) {
  if (poses.shape(0) != bodies.size()) throw nb::value_error("there have to be as many poses as bodies");
  std::vector<PosedPolytope> out;
  for (std::size_t i = 0; i < bodies.size(); ++i) out.push_back({bodies[i].get(), pose_from(poses.data() + 16 * i)});
  return out;
}

GivenPoints given(InputArray<double, -1, 3> points, InputArray<double, -1> radii) {
  const std::size_t n = points.shape(0);
  if (radii.shape(0) != 1 && radii.shape(0) != n) throw nb::value_error("there have to be as many radii as points");
  return {points.data(), radii.data(), radii.shape(0) == 1 ? std::size_t{0} : std::size_t{1}, n};
}

auto near_bodies(const Bodies& bodies, PoseRows poses, InputArray<double, -1, 3> points, InputArray<double, -1> radii) {
  const std::vector<PosedPolytope> placed = posed(bodies, poses);
  const GivenPoints all = given(points, radii);
  std::vector<std::uint8_t> near(all.count);
  without_gil([&] { points_near_bodies(placed, all, near.data()); });
  return output_array(near, {all.count});
}

// (distances, lower bounds) of points and groups of bodies.
nb::tuple distances(const Bodies& bodies, PoseRows poses, const std::vector<std::int32_t>& group, std::size_t groups,
                    InputArray<double, -1, 3> points, InputArray<double, -1> limits) {
  const std::vector<PosedPolytope> placed = posed(bodies, poses);
  const GivenPoints all = given(points, limits);
  const auto is_unknown = [&](std::int32_t g) { return g < 0 || static_cast<std::size_t>(g) >= groups; };
  if (group.size() != bodies.size() || std::any_of(group.begin(), group.end(), is_unknown))
    throw nb::value_error("each body has to have one of the groups");
  PointDistances found;
  without_gil([&] { found = distances_of_points(placed, group, groups, all); });
  return nb::make_tuple(output_array(found.upper, {all.count, groups}), output_array(found.lower, {all.count, groups}));
}

}  // namespace

void bind_points(nb::module_& m) {
  m.def("points_near_hull", &near_hull, nb::arg("body"), nb::arg("pose"), nb::arg("frame"), nb::arg("xyz"),
        nb::arg("radii"), nb::arg("filters") = true, plain_floats);
  m.def("points_near_bodies", &near_bodies, nb::arg("bodies"), nb::arg("poses"), nb::arg("points"), nb::arg("radii"),
        plain_floats);
  m.def("distances_of_points", &distances, nb::arg("bodies"), nb::arg("poses"), nb::arg("group"), nb::arg("groups"),
        nb::arg("points"), nb::arg("limits"), plain_floats);
}

}  // namespace plannercheck
