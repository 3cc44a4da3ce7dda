// States that are tested together, one in each float lane.
#pragma once

#include <array>
#include <cstddef>

#include "math/simd.hpp"

namespace plannercheck {

// As many as floats fill a register, and eight at least: twice as many lanes take less than twice the time, because two
// successive blocks mostly ask for the same pairs.
inline constexpr int kBlockStates = 2 * kLanes < kFloats ? kFloats : 2 * kLanes;
inline constexpr int kBlockGroups = kBlockStates / kLanes;  // groups of Lanes that hold one number of each state
static_assert(kBlockGroups * kLanes == kBlockStates);

typedef float StateFloats __attribute__((vector_size(kBlockStates * 4)));
typedef int StateMask __attribute__((vector_size(kBlockStates * 4)));

// Index into the link poses of a block: number i of the row-major 3x4 matrix of a link, for the states of a group.
inline std::size_t pose_index(std::size_t links, std::size_t group, std::size_t link) {
  return (group * links + link) * 12;
}

// A row-major 3x4 matrix in every lane, rounded to floats: for filters.
template <FloatVector Numbers>
struct FloatPoseOf {
  std::array<Numbers, 12> m;

  // Row i times a vector.
  Numbers turned(std::size_t i, Numbers x, Numbers y, Numbers z) const {
    return dot_of(m[4 * i], m[4 * i + 1], m[4 * i + 2], x, y, z);
  }
  Numbers turned(std::size_t i, float x, float y, float z) const {
    return turned(i, filled<Numbers>(x), filled<Numbers>(y), filled<Numbers>(z));
  }
};
typedef FloatPoseOf<StateFloats> FloatPose;  // in every state of a block
typedef FloatPoseOf<Floats> FloatStatePose;  // of one state, in lanes over what is posed by it

inline void round_to_floats(const Lanes* poses, std::size_t links, std::size_t link, FloatPose& out) {
  const Lanes* const from = poses + pose_index(links, 0, link);
  for (std::size_t i = 0; i < out.m.size(); ++i) out.m[i] = joined_floats<kBlockStates>(from + i, links * 12);
}

}  // namespace plannercheck
