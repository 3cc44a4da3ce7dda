// A planar robot, its bodies and pairs as arrays from Python.
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <vector>

#include "bindings/array_types.hpp"
#include "planar/checker_2d.hpp"

namespace plannercheck {
namespace planar_arrays {

inline std::vector<PlanarLink> links_from(InputArray<std::int32_t, -1, 3> links, InputArray<double, -1, 3> anchors) {
  std::vector<PlanarLink> out;
  for (std::size_t i = 0; i < links.shape(0); ++i) {
    out.push_back(
        {links(i, 0), static_cast<PlanarJoint>(links(i, 1)), links(i, 2), anchors(i, 0), anchors(i, 1), anchors(i, 2)});
  }
  return out;
}

inline std::vector<PlanarGeometryObject> bodies_from(const nanobind::list& polygons,
                                                     InputArray<std::int32_t, -1> mounts,
                                                     InputArray<double, -1, 3, 3> poses,
                                                     InputArray<double, -1, 3> circles,
                                                     InputArray<double, -1, 4> boxes) {
  std::vector<PlanarGeometryObject> out;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    const auto vertices = nanobind::cast<InputArray<double, -1, 2>>(polygons[i], false);
    PlanarGeometryObject body{{vertices.data(), vertices.shape(0)},
                              mounts(i),
                              {},
                              circles(i, 0),
                              circles(i, 1),
                              circles(i, 2),
                              {boxes(i, 0), boxes(i, 1), boxes(i, 2), boxes(i, 3)}};
    std::copy_n(poses.data() + 9 * i, 6, body.pose.m.begin());
    out.push_back(body);
  }
  return out;
}

}  // namespace planar_arrays
}  // namespace plannercheck
