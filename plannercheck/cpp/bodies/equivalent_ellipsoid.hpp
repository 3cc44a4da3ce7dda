// The ellipsoid with a hull's volume, centroid and second moments. It suggests how two bodies face each other; for long
// or flat bodies the axis between their centres does not.
#pragma once

#include <array>
#include <vector>

#include "bodies/hull.hpp"
#include "math/vec.hpp"

namespace plannercheck {

struct EquivalentEllipsoid {
  Vec3 middle;
  // Symmetric, xx yy zz yz zx xy, m²: the support along u is the root of uᵀ form u.
  std::array<double, 6> form{};
  bool exists = false;   // there is volume
  bool is_round = true;  // nearly a ball
};

EquivalentEllipsoid equivalent_ellipsoid(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles);

// Approximately the normal of a plane between two posed ellipsoids that are apart or touch, from the second to the
// first, with largest entry 1; NaN where there is none.
Vec3 direction_between(const EquivalentEllipsoid& a, const Pose& pose_a, const EquivalentEllipsoid& b,
                       const Pose& pose_b);

}  // namespace plannercheck
