// A solid at a pose: its points in doubles, and how far rounding may move them.
//
// Poses are affine maps that are rigid up to 3.6e-6 (bodies/shapes.py), in the norm of MᵀM − 1.
#pragma once

#include <array>
#include <cmath>

#include "bodies/solid.hpp"
#include "math/predicates.hpp"
#include "math/vec.hpp"

namespace plannercheck {

struct PosedSolid {
  const Solid* solid;
  Pose pose;

  Vec3 corner(std::int32_t triangle, std::size_t k) const {
    return pose.apply(solid->points[at(solid->triangles[at(triangle)][k])]);
  }
};

// How much longer than in the world a length may be in the frame of a body that is as far off rigid as poses may be.
inline constexpr double kFrameStretch = 1 + 0x1p-16;

// The inverse of a pose, in doubles.
class InversePose {
 public:
  explicit InversePose(const Pose& pose);

  // M⁻¹ v
  Vec3 rotate(Vec3 v) const { return {dot(rows_[0], v), dot(rows_[1], v), dot(rows_[2], v)}; }
  // M⁻¹ (v − t)
  Vec3 apply(Vec3 v) const { return rotate(v - translation_); }

  // How far apply(p) is at most from the exact image in each coordinate, where p is the image of a point under
  // Pose::apply of this magnitude.
  double error(double magnitude) const;

 private:
  std::array<Vec3, 3> rows_;
  Vec3 translation_;
};

// From one posed body's frame to another one's, in doubles: M_b⁻¹ (M_a x + t_a − t_b).
class RelativePose {
 public:
  RelativePose(const Pose& from, const Pose& to);

  Vec3 apply(Vec3 p) const { return pose_.apply(p); }

  // How far apply(p) is at most from the exact image in each coordinate, for |p|_1 at most `reach`.
  double error(double reach) const;

  const Pose& pose() const { return pose_; }

 private:
  Pose pose_;
  double distance_;  // |t_a − t_b|_1
};

}  // namespace plannercheck
