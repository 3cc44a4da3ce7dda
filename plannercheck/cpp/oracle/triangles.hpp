// Two posed triangles: do they share a point, and are they within the inflation radii of each other? Exact; triangles
// may be segments or points, and may lie in one plane.
#pragma once

#include "oracle/posed_mesh.hpp"

namespace plannercheck::oracle {

bool triangles_meet(const MeshPair& pair, const Triangle& s, const Triangle& t);

// Whether the distance of two triangles that share no point is at most the sum of the inflation radii.
bool triangles_within_radii(const MeshPair& pair, const Triangle& s, const Triangle& t);

// The sign of (b − a) × (c − a) · (d − a).
int orientation(const MeshPair& pair, const Corner& a, const Corner& b, const Corner& c, const Corner& d);

// The sign of (b − a) × (c − a), of the projections along axis `drop`.
int orientation_in_plane(const MeshPair& pair, const Corner& a, const Corner& b, const Corner& c, int drop);

// The sign of coordinate `axis` of a − b.
int compare(const MeshPair& pair, const Corner& a, const Corner& b, int axis);

}  // namespace plannercheck::oracle
