// Two posed meshes: do their sets share a point? Exact, by definition.
//
// In: two meshes, each with a pose. Out: the verdict and its reason. Triangles of both are compared in all pairs whose
// boxes overlap. If no triangles meet, each connected part of one mesh lies as a whole inside or outside of the other
// set, so one vertex decides.
#pragma once

#include "oracle/posed_mesh.hpp"

namespace plannercheck::oracle {

enum class Meeting : std::uint8_t {
  kNone = 0,
  kTriangles = 1,     // of both share a point
  kWithinRadii = 2,   // triangles of both are no further apart than the inflation radii
  kFirstInside = 3,   // a part of the first mesh is inside the second
  kSecondInside = 4,  // and the other way round
};

// `every`: whole numbers alone, every pair of triangles, every vertex.
Meeting meeting(const MeshPair& pair, bool every);

}  // namespace plannercheck::oracle
