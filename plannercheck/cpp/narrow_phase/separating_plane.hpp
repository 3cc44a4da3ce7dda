// The plane between two bodies that share no point, as the certificates of plannercheck/bodies give it.
//
// In: two posed bodies that share no point. Out: a direction whose exact extents prove that a plane separates them, and
// that plane halfway between them, each number rounded once. Solids are separated by their hulls, sets of parts by the
// hull of their corners, or the box around very many; where these meet, several planes are needed, and there is none.
// This header is free of lanes.
#pragma once

#include <optional>

#include "math/vec.hpp"

namespace plannercheck {

struct PosedPolytope;
struct PairCounters;

struct SeparatingPlane {
  Vec3 normal;        // of length 1, in the world, from B to A
  double offset = 0;  // m, of normal · x, halfway between the bodies
  double gap = 0;     // a lower bound of their distance, m
};

std::optional<SeparatingPlane> separating_plane(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters);

}  // namespace plannercheck
