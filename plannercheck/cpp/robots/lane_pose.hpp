// Poses of kLanes configurations at once, in doubles, and how joints move them (pose_rows.hpp places them).
#pragma once

#include <array>
#include <cstddef>

#include "math/simd.hpp"
#include "math/sincos.hpp"
#include "robots/joints.hpp"
#include "robots/kinematics.hpp"
#include "robots/pose_rows.hpp"

namespace plannercheck {

inline constexpr std::size_t kPoseNumbers = 12;  // of a row-major 3x4 pose

struct LanePose {
  Lanes m[kPoseNumbers];

  // By a rotation, 3x3 and row-major.
  void rotate(const std::array<Lanes, 9>& r) {
#pragma GCC unroll 3
    for (std::size_t row = 0; row < 3; ++row) {
      const Lanes a = m[4 * row], b = m[4 * row + 1], c = m[4 * row + 2];
#pragma GCC unroll 3
      for (std::size_t col = 0; col < 3; ++col) m[4 * row + col] = a * r[col] + b * r[3 + col] + c * r[6 + col];
    }
  }

  void slide(Lanes x, Lanes y, Lanes z) {
#pragma GCC unroll 3
    for (std::size_t k = 0; k < 3; ++k) {
      Lanes* const row = m + 4 * k;
      row[3] = row[0] * x + row[1] * y + row[2] * z + row[3];
    }
  }

  template <std::size_t from, std::size_t to>
  void turn(Lanes cos, Lanes sin) {
    turn_columns<from, to>(m, cos, sin);
  }
};

// The same pose in all lanes; −0 becomes 0.
inline LanePose lane_pose(const Rigid& pose) {
  LanePose out;
#pragma GCC unroll 12
  for (std::size_t k = 0; k < kPoseNumbers; ++k) out.m[k] = broadcast(pose.m[k]);
  return out;
}

inline LanePose load_pose(const Lanes* from) {
  LanePose out;
#pragma GCC unroll 12
  for (std::size_t k = 0; k < kPoseNumbers; ++k) out.m[k] = from[k];
  return out;
}

inline void store_pose(Lanes* to, const LanePose& pose) {
#pragma GCC unroll 12
  for (std::size_t k = 0; k < kPoseNumbers; ++k) to[k] = pose.m[k];
}

inline Lanes value_of(const JointValue& value, const Lanes* q) {
  return value.column < 0 ? broadcast(value.offset) : value.multiplier * q[value.column] + value.offset;
}

// Reads a joint's values in the form that `move` takes.
inline void read_values(JointKind kind, const JointValue* values, const Lanes* q, Lanes* v) {
  if (is_angle(kind)) {
    const SinCos turn = sincos(value_of(values[0], q));
    v[0] = turn.cos;
    v[1] = turn.sin;
    return;
  }
  for (int k = 0; k < value_count(kind); ++k) v[k] = value_of(values[k], q);
}

}  // namespace plannercheck
