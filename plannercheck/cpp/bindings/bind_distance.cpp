// Distances of single pairs in Python, with the GIL released.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <numeric>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "narrow_phase/distance.hpp"
#include "narrow_phase/part_depth.hpp"
#include "narrow_phase/penetration_depth.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

void put_row(std::vector<double>& rows, std::size_t i, Vec3 v) {
  rows[3 * i] = v.x, rows[3 * i + 1] = v.y, rows[3 * i + 2] = v.z;
}

// (overlap, distance, lower bound, points on a, points on b, directions from b to a) for n pairs of poses of the same
// two bodies.
nb::tuple distance_batch(const Polytope& a, PoseRows poses_a, const Polytope& b, PoseRows poses_b, bool depths) {
  const std::size_t n = std::max(poses_a.shape(0), poses_b.shape(0)), axes = 3;
  std::vector<std::uint8_t> overlap(n);
  std::vector<double> distance(n), lower(n), on_a(axes * n), on_b(axes * n), directions(axes * n);
  without_gil([&] {
    PairCounters counters;
    for (std::size_t i = 0; i < n; ++i) {
      poll_interruption();
      const PosedPolytope first{&a, pose_at(poses_a, i)}, second{&b, pose_at(poses_b, i)};
      const PairDistance found =
          depths ? signed_distance(first, second, counters) : pair_distance(first, second, kNoLimit, counters);
      overlap[i] = found.overlap, distance[i] = found.upper, lower[i] = found.lower;
      put_row(on_a, i, found.on_body_a), put_row(on_b, i, found.on_body_b), put_row(directions, i, found.direction);
    }
  });
  return nb::make_tuple(output_array(overlap, {n}), output_array(distance, {n}), output_array(lower, {n}),
                        output_array(on_a, {n, axes}), output_array(on_b, {n, axes}),
                        output_array(directions, {n, axes}));
}

// (n,) lower bounds of the distance of hulls, after some steps: cheap where bodies overlap, too.
auto distance_bounds(const Polytope& a, PoseRows poses_a, const Polytope& b, PoseRows poses_b, int rounds) {
  const std::size_t n = std::max(poses_a.shape(0), poses_b.shape(0));
  std::vector<double> lower(n);
  without_gil([&] {
    PairCounters counters;
    for (std::size_t i = 0; i < n; ++i) {
      poll_interruption();
      lower[i] = distance_bound({&a, pose_at(poses_a, i)}, {&b, pose_at(poses_b, i)}, rounds, counters);
    }
  });
  return output_array(lower, {n});
}

// (lower, upper) bounds of the depth of two hulls that share a point.
auto hull_depth_of(const Polytope& a, PoseRows pose_a, const Polytope& b, PoseRows pose_b, bool doubles) {
  PairCounters counters;
  const HullDepth found =
      hull_depth({&a, pose_at(pose_a, 0)}, {&b, pose_at(pose_b, 0)}, Proximity{}, counters, doubles);
  return nb::make_tuple(found.lower, found.upper);
}

}  // namespace

void bind_distance(nb::module_& m) {
  m.def("distance_bounds", &distance_bounds, plain_floats);
  m.def("distance_batch", &distance_batch, nb::arg(), nb::arg(), nb::arg(), nb::arg(), nb::arg("depths") = false,
        plain_floats);
  m.def("hull_depth", &hull_depth_of, plain_floats);
}

}  // namespace plannercheck
