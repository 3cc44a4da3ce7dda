// Wedge refinement at vertices of large degree: builds and checks Levels::fans, wedges and entries.
//
// Why one edge is enough: let u lie in v's normal cone at some level, in the wedge of the edge v r (spanned by the axis
// z_v and the normals of the two facets along the edge). A vertex c of the next finer level lies beyond the plane
// through v with normal u only if u · (c − v) > 0. That half-space does not contain z_v, which is inside v's cone in
// the finest level. So the ray from z_v through u, once in the half-space, stays there until it leaves the cone,
// between the normals of these two facets. Hence c lies above one of the two facets, and each has at most one removed
// vertex above it. Two side tests then tell which of at most three new wedges holds u.
#pragma once

#include <string>

#include "bodies/hierarchy.hpp"
#include "bodies/triangulation.hpp"

namespace plannercheck {

// `coarsest` is the triangulation of the top vertices.
void build_wedges(const ConvexMesh& mesh, const Triangulation& coarsest, Levels& levels);

std::string wedge_fault(const ConvexMesh& mesh, const Levels& levels);

}  // namespace plannercheck
