// How often a posed mesh winds around a point, exactly: signed crossings of one ray.
//
// In: a point, a posed mesh with it not on its triangles. Out: the winding number. The ray runs along x from the point
// moved by an infinitesimal in y and by its square in z, so it passes through no edge and no vertex; off the triangles
// the winding number is the same there.
#pragma once

#include <optional>

#include "oracle/posed_mesh.hpp"

namespace plannercheck::oracle {

// Nothing if the point is found on a triangle, which is looked for only where the ray starts.
std::optional<std::int64_t> winding_number(const MeshPair& pair, const Corner& point, const PosedMesh& mesh);

}  // namespace plannercheck::oracle
