// Polygons in the plane, in Python.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cmath>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "planar/polygon_test.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using PolygonArray = InputArray<double, -1, 2>;
using PlanarPoseRows = InputArray<double, -1, 3, 3>;

// Arrays of vertices as they are, kept alive.
struct PolygonList {
  explicit PolygonList(const nb::list& given) : arrays(given) {
    polygons.reserve(given.size());
    for (const nb::handle item : given) {
      const auto array = nb::cast<PolygonArray>(item, false);
      polygons.push_back({array.data(), array.shape(0)});
    }
  }

  const PlanarPolygon& of_pair(std::size_t i) const { return polygons[polygons.size() == 1 ? 0 : i]; }

  nb::list arrays;
  std::vector<PlanarPolygon> polygons;
};

PlanarPose planar_pose(const PlanarPoseRows& poses, std::size_t k) {
  PlanarPose pose;
  const double* rows = poses.data() + (poses.shape(0) == 1 ? 0 : 9 * k);
  std::copy_n(rows, 6, pose.m.begin());
  return pose;
}

bool are_affine(PlanarPoseRows poses) {
  for (std::size_t k = 0; k < poses.shape(0); ++k) {
    const double* last = poses.data() + 9 * k + 6;
    if (last[0] != 0 || last[1] != 0 || last[2] != 1) return false;
  }
  return true;
}

// The first pose that is not finite or whose ||M^T M - 1|| exceeds `largest`; -1 if there is none.
std::int64_t first_bent_pose(PlanarPoseRows poses, double largest) {
  for (std::size_t k = 0; k < poses.shape(0); ++k) {
    const double* m = poses.data() + 9 * k;
    const double xx = m[0] * m[0] + m[3] * m[3] - 1, xy = m[0] * m[1] + m[3] * m[4], yy = m[1] * m[1] + m[4] * m[4] - 1;
    const bool rigid = std::sqrt(xx * xx + 2 * xy * xy + yy * yy) <= largest && m[0] * m[4] - m[1] * m[3] > 0;
    if (!rigid || !std::isfinite(m[2]) || !std::isfinite(m[5])) return static_cast<std::int64_t>(k);
  }
  return -1;
}

// What one pass over a polygon finds that the algorithm takes for granted: it reads a logarithmic part of the vertices.
enum VertexFault : int { kSound, kRepeated, kNotFinite };

bool same_vertex(const double* v, std::size_t a, std::size_t b) {
  return v[2 * a] == v[2 * b] && v[2 * a + 1] == v[2 * b + 1];
}

int vertex_fault(PolygonArray polygon) {
  const double* v = polygon.data();
  const std::size_t n = polygon.shape(0);
  int fault = kSound;
  for (std::size_t k = 0; k < n; ++k) {
    if (!std::isfinite(v[2 * k]) || !std::isfinite(v[2 * k + 1])) return kNotFinite;
    if (k > 0 && same_vertex(v, k, k - 1)) fault = kRepeated;
  }
  return fault;
}

// Whether the last vertex repeats the first. Not done in Python, where a thread that flushes denormals to zero would
// find different vertices equal.
bool is_closed(PolygonArray polygon) {
  return polygon.shape(0) > 1 && same_vertex(polygon.data(), 0, polygon.shape(0) - 1);
}

// (n,), 1 where a vertex repeats the one before.
auto repeated_vertices(PolygonArray polygon) {
  std::vector<std::uint8_t> repeated(polygon.shape(0));
  for (std::size_t k = 1; k < repeated.size(); ++k) repeated[k] = same_vertex(polygon.data(), k, k - 1);
  return output_array(repeated, {repeated.size()});
}

// Verdicts on n pairs, and the counters of each if wanted. Lists and poses of length 1 are used for all pairs.
nb::tuple planar_intersect_batch(const PolygonList& a, PlanarPoseRows poses_a, const PolygonList& b,
                                 PlanarPoseRows poses_b, std::size_t n, Precision first, bool count) {
  std::vector<std::uint8_t> shared(n);
  std::vector<std::int32_t> counted(count ? 4 * n : 0);
  without_gil([&] {
    for (std::size_t i = 0; i < n; ++i) {
      poll_interruption();
      PlanarCounters counters;
      const PosedPolygon posed_a{a.of_pair(i), planar_pose(poses_a, i)};
      const PosedPolygon posed_b{b.of_pair(i), planar_pose(poses_b, i)};
      shared[i] = planar_intersect(posed_a, posed_b, first, counters);
      if (!count) continue;
      const long numbers[4] = {counters.rounds, counters.vertices, counters.double_double, counters.exact};
      for (std::size_t k = 0; k < 4; ++k) counted[4 * i + k] = static_cast<std::int32_t>(numbers[k]);
    }
  });
  return nb::make_tuple(output_array(shared, {n}), output_array(counted, {count ? n : 0, std::size_t{4}}));
}

}  // namespace

void bind_planar(nb::module_& m) {
  nb::enum_<Precision>(m, "Precision")
      .value("filtered", Precision::kDoubles)
      .value("double_double", Precision::kDoubleDouble)
      .value("exact", Precision::kExact);
  nb::class_<PolygonList>(m, "PolygonList").def(nb::init<const nb::list&>(), plain_floats);
  m.def("are_affine", &are_affine, plain_floats);
  m.def("first_bent_pose", &first_bent_pose, plain_floats);
  m.def("vertex_fault", &vertex_fault, plain_floats);
  m.def("is_closed", &is_closed, plain_floats);
  m.def("repeated_vertices", &repeated_vertices, plain_floats);
  m.def("planar_intersect_batch", &planar_intersect_batch, plain_floats);
  bind_planar_checker(m);
}

}  // namespace plannercheck
