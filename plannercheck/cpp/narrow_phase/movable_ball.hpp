// A body of one vertex with a radius, which is moved from point to point without a new preparation.
#pragma once

#include "bodies/polytope.hpp"

namespace plannercheck {

// Each thread has one body, which its next call moves. All tests but those with solids take it as a prepared body.
const Polytope& ball_at(Vec3 point, double radius);

// The same body, prepared for tests with solids as well; it allocates.
const Polytope& ball_with_surface_at(Vec3 point, double radius);

// A body of radius 0 at the origin, which never moves.
const Polytope& point_at_origin();

}  // namespace plannercheck
