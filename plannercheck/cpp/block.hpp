// States that are judged together, one a float lane.
#pragma once

#include <cstddef>

#include "simd.hpp"

namespace plannercheck {

inline constexpr int kBlockStates = kFloats;
inline constexpr int kBlockGroups = kBlockStates / kLanes;  // of Lanes that hold a number of each of them
static_assert(kBlockGroups * kLanes == kBlockStates);

// Link poses of a block: number i of the row-major 3x4 matrix of a link, for the states of a group.
inline std::size_t pose_index(std::size_t links, std::size_t group, std::size_t link) {
  return (group * links + link) * 12;
}

}  // namespace plannercheck
