// States that are tested together, one in each float lane.
#pragma once

#include <array>
#include <cstddef>

#include "math/simd.hpp"

namespace plannercheck {

inline constexpr int kBlockStates = kFloats;
inline constexpr int kBlockGroups = kBlockStates / kLanes;  // groups of Lanes that hold one number of each state
static_assert(kBlockGroups * kLanes == kBlockStates);

// Index into the link poses of a block: number i of the row-major 3x4 matrix of a link, for the states of a group.
inline std::size_t pose_index(std::size_t links, std::size_t group, std::size_t link) {
  return (group * links + link) * 12;
}

// A row-major 3x4 matrix in every state of a block, rounded to floats: for filters.
struct FloatPose {
  std::array<Floats, 12> m;

  // Row i times a vector.
  template <class Number>
  Floats turned(std::size_t i, Number x, Number y, Number z) const {
    return (m[4 * i] * x + m[4 * i + 1] * y) + m[4 * i + 2] * z;
  }
};

inline void round_to_floats(const Lanes* poses, std::size_t links, std::size_t link, FloatPose& out) {
  const Lanes* const from = poses + pose_index(links, 0, link);
  for (std::size_t i = 0; i < out.m.size(); ++i) out.m[i] = joined_floats(from + i, links * 12);
}

}  // namespace plannercheck
