// The ellipsoid with a hull's volume, middle and second moments: a guess of how two bodies face each other, which the
// axis between their centres is not where they are long or flat.
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
  bool is_round = true;  // about a ball
};

EquivalentEllipsoid equivalent_ellipsoid(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles);

// About the normal of the plane between two posed ellipsoids that are apart or touch, from the second to the first, of
// largest entry 1; no numbers where there is none.
Vec3 direction_between(const EquivalentEllipsoid& a, const Pose& pose_a, const EquivalentEllipsoid& b,
                       const Pose& pose_b);

}  // namespace plannercheck
