// Forward kinematics of kLanes configurations at once: what kinematics.hpp is made of, for callers that keep lanes.
#pragma once

#include <cstddef>

#include "kinematics.hpp"
#include "simd.hpp"

namespace plannercheck {

// How many Lanes of scratch link_poses wants.
std::size_t scratch_size(const Kinematics& kinematics);

// Poses of the links for kLanes configurations. q: width() Lanes; out: link_count()*12 Lanes, row-major 3x4 each. Only
// links with needed[link] != 0 are written.
void link_poses(const Kinematics& kinematics, const Lanes* q, const unsigned char* needed, Lanes* scratch, Lanes* out);

}  // namespace plannercheck
