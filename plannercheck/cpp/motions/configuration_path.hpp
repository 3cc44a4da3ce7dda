// The straight segment between two configurations, interpolated joint by joint.
//
// In: which columns of a configuration form a circle, a quaternion, or a pose; two configurations. Out: the
// configuration at any parameter in [0, 1], and how fast each part turns and slides. Idea: every joint moves along a
// constant twist (a screw), as Pinocchio's `interpolate` does: angles and lengths linearly, a (cosine, sine) the short
// way round, a quaternion by slerp, planar and floating joints by the exponential of one twist.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

enum class PartKind : int {
  kCircle,  // cosine, sine
  kBall,    // quaternion x, y, z, w
  kPlanar,  // x, y, cosine, sine
  kFree,    // x, y, z, quaternion
};

struct PathPart {
  PartKind kind;
  std::int32_t column;  // the first one
};

// How far a part or joint turns (rad) and slides (m) from parameter 0 to 1, and its largest distance from its origin
// (m).
struct Rate {
  double turn = 0, slide = 0, extent = 0;
};

class ConfigurationPath {
 public:
  ConfigurationPath(std::size_t width, std::vector<PathPart> parts);

  // Columns that no part covers are interpolated linearly; for continuous joints the caller chooses the short way.
  void set(const double* q0, const double* q1);

  // Configurations at n parameters, column by column: q[column * stride + i].
  void at(const double* t, std::size_t n, std::size_t stride, double* q) const;

  double start(std::int32_t column) const { return q0_[static_cast<std::size_t>(column)]; }
  double end(std::int32_t column) const { return q1_[static_cast<std::size_t>(column)]; }
  // The rate of the part that begins at a column.
  Rate rate(std::int32_t column) const;
  // The largest number in both configurations; how far any of their circles and quaternions is off length 1.
  double largest() const { return largest_; }
  double off_unit() const { return off_unit_; }

 private:
  struct Twist {
    Vec3 turn, slide;  // in the moving frame
    double angle = 0;  // |turn|
  };

  std::vector<double> q0_, q1_;
  std::vector<PathPart> parts_;
  std::vector<Twist> twists_;
  std::vector<std::int32_t> linear_;  // columns that no part covers
  double largest_ = 0, off_unit_ = 0;

  void set_part(std::size_t part);
  void part_at(std::size_t part, double t, double* q, std::size_t stride) const;
};

}  // namespace plannercheck
