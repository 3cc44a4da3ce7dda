// A prepared body with its placement: on a link of the robot, or in the world.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "bodies/polytope.hpp"
#include "math/box.hpp"
#include "math/vec.hpp"

namespace plannercheck {

// A link's pose times a placement on it. Every verdict and every pose given out uses these operations in this order.
inline Pose placed_on(const std::array<double, 12>& link, const Pose& placement) {
  const auto& p = placement.m;
  Pose out;
  for (std::size_t i = 0; i < 12; i += 4) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double sum = (link[i] * p[j] + link[i + 1] * p[j + 4]) + link[i + 2] * p[j + 8];
      out.m[i + j] = j == 3 ? sum + link[i + 3] : sum;
    }
  }
  return out;
}

struct GeometryObject {
  std::shared_ptr<const Polytope> body;
  std::int32_t link = -1;  // −1: fixed to the world
  Pose placement;          // on the link, or in the world
};

// Around the placed hull, without the inflation radius.
inline Box box_around_hull(const GeometryObject& object) {
  Box box;
  for (const Vec3& v : object.body->inner.points) box.add(object.placement.apply(v));
  return box;
}

}  // namespace plannercheck
