// How often a closed solid's triangles wind around a point of the world, exactly.
//
// In: a posed solid and a point that is on none of its triangles: a vertex of another posed solid, or the image of any
// point under an affine map. Out: the winding number. Idea: triangles that the upward ray from the point passes are
// counted, those that face up as 1 and those that face down as −1, in the solid's own frame, where its vertices are
// exact doubles and the ray is along an axis. A ray that meets an edge or a vertex is thought to start at ε² further in
// x and ε further in y, for an ε as small as need be (simulation of simplicity, Edelsbrunner and Mücke 1990):
// differences of coordinates decide on which side it passes an edge. Signs are computed in doubles, or else exactly.
#pragma once

#include "math/vec.hpp"
#include "narrow_phase/posed_solid.hpp"

namespace plannercheck {

// `from`: the pose under which `point` is mapped into the world.
int winding_number(const PosedSolid& around, const Pose& from, Vec3 point);

}  // namespace plannercheck
