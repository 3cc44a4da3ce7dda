// Whether one of two posed bodies surely has a point in the balls and the rounded box inside the other one.
//
// In: two posed bodies whose inner shapes are known, as they are to every checker of configurations (inner_shapes.hpp).
// Out: true only if they share a point; false tells nothing. Idea: samples of each body, its balls and some of its
// vertices, are taken to the other one's frame in lanes. Of robots' links whose hulls share a point, and whose meshes
// do, that tells from a fifth to three quarters, in a tenth of the time that trees of triangles take.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

bool inner_shapes_overlap(const PosedPolytope& a, const PosedPolytope& b);

}  // namespace plannercheck
