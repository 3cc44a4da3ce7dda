// Rotations by which joints turn, 3x3 and row-major: by the same operations on doubles and on lanes of them.
#pragma once

#include <array>

#include "robots/kinematics.hpp"

namespace plannercheck {

constexpr bool is_angle(JointKind kind) { return kind <= JointKind::kTurnAxis; }

constexpr int value_count(JointKind kind) {
  switch (kind) {
    case JointKind::kSlide:
      return 1;
    case JointKind::kPlanar:
    case JointKind::kBall:
      return 4;
    case JointKind::kFree:
      return 7;
    default:
      return is_angle(kind) ? 1 : 2;
  }
}

// About a unit axis (Rodrigues' formula).
template <class Number>
inline std::array<Number, 9> turn_about_axis(const double* axis, Number cos, Number sin) {
  const Number x = sin * axis[0], y = sin * axis[1], z = sin * axis[2];
  const Number rest = 1.0 - cos;
  const Number u = rest * axis[0], v = rest * axis[1], w = rest * axis[2];
  const Number xy = u * axis[1], xz = u * axis[2], yz = v * axis[2];
  return {u * axis[0] + cos, xy - z, xz + y, xy + z, v * axis[1] + cos, yz - x, xz - y, yz + x, w * axis[2] + cos};
}

// Of a quaternion x, y, z, w, which is not normalised.
template <class Number>
inline std::array<Number, 9> turn_of_quaternion(const Number* q) {
  const Number x2 = 2.0 * q[0], y2 = 2.0 * q[1], z2 = 2.0 * q[2];
  const Number wx = x2 * q[3], wy = y2 * q[3], wz = z2 * q[3];
  const Number xx = x2 * q[0], xy = y2 * q[0], xz = z2 * q[0];
  const Number yy = y2 * q[1], yz = z2 * q[1], zz = z2 * q[2];
  return {1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx, 1.0 - (xx + yy)};
}

}  // namespace plannercheck
