// Polygons in the plane, in Python.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <vector>

#include "array_types.hpp"
#include "bindings.hpp"
#include "planar.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using PolygonArray = InputArray<double, -1, 2>;
using PlanarPoseRows = InputArray<double, -1, 3, 3>;

// Polygons of a list of arrays, or of one array; the arrays must outlive them.
std::vector<PlanarPolygon> polygons_from(const nb::list& arrays) {
  std::vector<PlanarPolygon> polygons;
  polygons.reserve(arrays.size());
  for (const nb::handle item : arrays) {
    const auto array = nb::cast<PolygonArray>(item, false);
    polygons.push_back({array.data(), array.shape(0)});
  }
  return polygons;
}

PlanarPose planar_pose(const PlanarPoseRows& poses, std::size_t k) {
  PlanarPose pose;
  const double* rows = poses.data() + (poses.shape(0) == 1 ? 0 : 9 * k);
  std::copy_n(rows, 6, pose.m.begin());
  return pose;
}

// Verdicts on n pairs; lists and poses of length 1 stand for all. Also the counters of each pair.
nb::tuple planar_intersect_batch(const nb::list& arrays_a, PlanarPoseRows poses_a, const nb::list& arrays_b,
                                 PlanarPoseRows poses_b, std::size_t n, Precision first, bool count) {
  const std::vector<PlanarPolygon> a = polygons_from(arrays_a), b = polygons_from(arrays_b);
  std::vector<std::uint8_t> shared(n);
  std::vector<std::int32_t> counted(count ? 4 * n : 0);
  {
    nb::gil_scoped_release release;
    for (std::size_t i = 0; i < n; ++i) {
      PlanarCounters counters;
      const PosedPolygon posed_a{a[a.size() == 1 ? 0 : i], planar_pose(poses_a, i)};
      const PosedPolygon posed_b{b[b.size() == 1 ? 0 : i], planar_pose(poses_b, i)};
      shared[i] = planar_intersect(posed_a, posed_b, first, counters);
      if (!count) continue;
      const long numbers[4] = {counters.rounds, counters.vertices, counters.double_double, counters.exact};
      for (std::size_t k = 0; k < 4; ++k) counted[4 * i + k] = static_cast<std::int32_t>(numbers[k]);
    }
  }
  return nb::make_tuple(output_array(shared, {n}), output_array(counted, {count ? n : 0, std::size_t{4}}));
}

}  // namespace

void bind_planar(nb::module_& m) {
  nb::enum_<Precision>(m, "Precision")
      .value("filtered", Precision::kDoubles)
      .value("double_double", Precision::kDoubleDouble)
      .value("exact", Precision::kExact);
  m.def("planar_intersect_batch", &planar_intersect_batch);
}

}  // namespace plannercheck
