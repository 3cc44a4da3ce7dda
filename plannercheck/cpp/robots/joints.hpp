// What joints do: their kinds, and how each moves a pose, by the same operations on doubles and on lanes of them.
//
// plannercheck/robots/joints.py describes the kinds; docs/explanation/add_a_part.md lists what a new one needs.
#pragma once

#include <array>

namespace plannercheck {

// How a joint moves its child. Angles: rad, URDF's sense; quaternions are x, y, z, w, not normalised, as in Pinocchio.
enum class JointKind : int {
  kTurnX,         // angle
  kTurnY,         // angle
  kTurnZ,         // angle
  kTurnAxis,      // angle
  kUnitTurnX,     // cosine, sine
  kUnitTurnY,     // cosine, sine
  kUnitTurnZ,     // cosine, sine
  kUnitTurnAxis,  // cosine, sine
  kSlide,         // distance along the axis
  kPlanar,        // x, y, cosine, sine (about z)
  kBall,          // quaternion
  kFree,          // x, y, z, quaternion
};

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

// ----- rotations, 3x3 and row-major

// About a unit axis (Rodrigues' formula).
template <class Number>
inline std::array<Number, 9> turn_about_axis(const double* axis, Number cos, Number sin) {
  const Number x = sin * axis[0], y = sin * axis[1], z = sin * axis[2];
  const Number rest = 1.0 - cos;
  const Number u = rest * axis[0], v = rest * axis[1], w = rest * axis[2];
  const Number xy = u * axis[1], xz = u * axis[2], yz = v * axis[2];
  return {u * axis[0] + cos, xy - z, xz + y, xy + z, v * axis[1] + cos, yz - x, xz - y, yz + x, w * axis[2] + cos};
}

// The rotation of a quaternion x, y, z, w, which is not normalised.
template <class Number>
inline std::array<Number, 9> turn_of_quaternion(const Number* q) {
  const Number x2 = 2.0 * q[0], y2 = 2.0 * q[1], z2 = 2.0 * q[2];
  const Number wx = x2 * q[3], wy = y2 * q[3], wz = z2 * q[3];
  const Number xx = x2 * q[0], xy = y2 * q[0], xz = z2 * q[0];
  const Number yy = y2 * q[1], yz = z2 * q[1], zz = z2 * q[2];
  return {1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx, 1.0 - (xx + yy)};
}

// ----- motions

// Moves a pose by a joint. Pose: `slide` and `rotate` it in its own frame, `turn` takes one of its columns towards
// another. v: the joint's values, cosine and sine in place of an angle.
template <class Pose, class Number>
[[gnu::always_inline]] inline void move(Pose& pose, JointKind kind, const double* axis, const Number* v) {
  switch (kind) {
    case JointKind::kTurnX:
    case JointKind::kUnitTurnX:
      return pose.template turn<1, 2>(v[0], v[1]);
    case JointKind::kTurnY:
    case JointKind::kUnitTurnY:
      return pose.template turn<2, 0>(v[0], v[1]);
    case JointKind::kTurnZ:
    case JointKind::kUnitTurnZ:
      return pose.template turn<0, 1>(v[0], v[1]);
    case JointKind::kTurnAxis:
    case JointKind::kUnitTurnAxis:
      return pose.rotate(turn_about_axis(axis, v[0], v[1]));
    case JointKind::kSlide:
      return pose.slide(v[0] * axis[0], v[0] * axis[1], v[0] * axis[2]);
    case JointKind::kPlanar:
      pose.slide(v[0], v[1], Number{});
      return pose.template turn<0, 1>(v[2], v[3]);
    case JointKind::kBall:
      return pose.rotate(turn_of_quaternion(v));
    case JointKind::kFree:
      pose.slide(v[0], v[1], v[2]);
      return pose.rotate(turn_of_quaternion(v + 3));
  }
}

}  // namespace plannercheck
