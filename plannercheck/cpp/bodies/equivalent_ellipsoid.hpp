// The ellipsoid with a hull's volume, middle and second moments: a guess of how two bodies face each other, which the
// axis between their centres is not where they are long or flat.
#pragma once

#include <array>
#include <vector>

#include "bodies/hull.hpp"
#include "math/vec.hpp"

namespace plannercheck {

struct AlikeEllipsoid {
  Vec3 middle;
  // Symmetric, xx yy zz yz zx xy, m²: the support along u is the root of uᵀ form u.
  std::array<double, 6> form{};
  bool exists = false;   // there is volume
  bool is_round = true;  // about a ball
};

AlikeEllipsoid alike_ellipsoid(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles);

// About the normal of the plane between two posed ellipsoids that are apart or touch, from the second to the first, of
// largest entry 1; no numbers where there is none.
Vec3 direction_between(const AlikeEllipsoid& a, const Pose& pose_a, const AlikeEllipsoid& b, const Pose& pose_b);

}  // namespace plannercheck
