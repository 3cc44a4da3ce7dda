// Balls and a box inside a solid.
//
// In: a solid. Out: shapes as of inner_shapes.hpp, in the solid's frame; none if it encloses nothing, or is as thin as
// rounding. Idea: a ball or a box that no triangle meets has one winding number throughout, and lies in the solid if
// the winding number of its middle is not 0. A triangle is further than r from a ball's centre or a box if its corners
// are further than r along some direction. Winding numbers are counted along a ray by exact signs; if the ray meets an
// edge, the point is dropped.
#pragma once

#include "bodies/inner_shapes.hpp"

namespace plannercheck {

struct Solid;

InnerShapes inner_shapes_of(const Solid& solid);

// Whether a closed solid winds around a point; false also if rounding, or where the ray goes, leaves that open.
bool surely_winds_around(const Solid& solid, Vec3 point);

// How large a ball around a point is in a closed solid, at least; 0 where nothing is known.
double inner_radius(const Solid& solid, Vec3 point);

}  // namespace plannercheck
