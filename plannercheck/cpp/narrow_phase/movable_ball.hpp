// A body of one vertex with a radius, which is moved from point to point without a new preparation.
#pragma once

#include "bodies/polytope.hpp"

namespace plannercheck {

// One for each thread; its next call moves the same body. Equal to a prepared one for all tests but those with solids.
const Polytope& ball_at(Vec3 point, double radius);

// The same, also for tests with solids; it allocates.
const Polytope& ball_with_surface_at(Vec3 point, double radius);

// One at the origin, of radius 0, which stays there.
const Polytope& point_at_origin();

}  // namespace plannercheck
