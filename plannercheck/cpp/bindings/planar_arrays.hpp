// A planar robot, its bodies and pairs from Python's arrays: what PlanarChecker and PlanarCertifier take.
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "bindings/array_types.hpp"
#include "planar/checker_2d.hpp"

namespace plannercheck {

struct PlanarModel {
  std::vector<PlanarLink> links;
  std::int32_t width;  // of a configuration
  std::vector<PlanarGeometryObject> bodies;
  std::vector<std::array<std::int32_t, 2>> pairs;
  nanobind::list polygons;  // arrays of the bodies' vertices; whoever takes the bodies keeps them alive

  // joints: rows of parent, joint, column; anchors: rows of x, y, angle. circles: rows of x, y, radius of each body;
  // boxes: rows of least x, y, largest x, y.
  PlanarModel(InputArray<std::int32_t, -1, 3> joints, InputArray<double, -1, 3> anchors, std::int32_t columns,
              nanobind::list vertices, InputArray<std::int32_t, -1> mounts, InputArray<double, -1, 3, 3> poses,
              InputArray<double, -1, 3> circles, InputArray<double, -1, 4> boxes,
              InputArray<std::int32_t, -1, 2> listed)
      : width(columns), pairs(pairs_from(listed)), polygons(std::move(vertices)) {
    for (std::size_t i = 0; i < joints.shape(0); ++i) {
      links.push_back({joints(i, 0), static_cast<PlanarJoint>(joints(i, 1)), joints(i, 2), anchors(i, 0), anchors(i, 1),
                       anchors(i, 2)});
    }
    for (std::size_t i = 0; i < polygons.size(); ++i) {
      const auto polygon = nanobind::cast<InputArray<double, -1, 2>>(polygons[i], false);
      bodies.push_back({{polygon.data(), polygon.shape(0)},
                        mounts(i),
                        {},
                        circles(i, 0),
                        circles(i, 1),
                        circles(i, 2),
                        {boxes(i, 0), boxes(i, 1), boxes(i, 2), boxes(i, 3)}});
      std::copy_n(poses.data() + 9 * i, 6, bodies.back().pose.m.begin());
    }
  }
};

}  // namespace plannercheck
