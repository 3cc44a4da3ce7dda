// The path of a motion: all that knows which curve the numbers of a motion define.
//
// In: which columns of a configuration form a circle, a quaternion, or a pose; a motion's numbers, which are two
// configurations. Out: the configuration at any parameter in [0, 1]; bounds, on all of it, of each number and of how
// fast each part turns and slides. Idea: every joint moves along a constant twist (a screw), as Pinocchio's
// `interpolate` does: angles and lengths linearly, a (cosine, sine) the short way round, a quaternion by slerp, planar
// and floating joints by the exponential of one twist. So no second derivative of an angle or a length counts, and the
// bounds of an interval are those of the whole path.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

// The numbers of a motion: its ends.
struct Segment {
  const double *start, *end;
};

// Those of several motions, `width` numbers an end.
struct Segments {
  const double *starts, *ends;
  std::size_t width;

  Segment operator[](std::size_t i) const { return {starts + i * width, ends + i * width}; }
  Segments from(std::size_t first) const { return {starts + first * width, ends + first * width, width}; }
};

// Whether each of n numbers stays between bounds on a motion; those of unit vectors are at most 1 and do not count.
inline bool stays_within(const Segment& motion, std::size_t n, const double* low, const double* high) {
  bool within = true;
  for (std::size_t c = 0; c < n; ++c) {
    within &= motion.start[c] >= low[c] && motion.start[c] <= high[c];
    within &= motion.end[c] >= low[c] && motion.end[c] <= high[c];
  }
  return within;
}

// How much a number that no part covers changes on a motion.
inline double change(const Segment& motion, std::size_t column) {
  return std::fabs(motion.end[column] - motion.start[column]);
}

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

// Of a number: how much it changes from parameter 0 to 1, and its largest magnitude.
struct NumberBound {
  double rate, size;
};

class Path {
 public:
  Path(std::size_t width, std::vector<PathPart> parts);

  // Columns that no part covers are interpolated linearly; for continuous joints the caller chooses the short way.
  void set(const Segment& motion);

  // Configurations at n parameters, column by column: q[column * stride + i].
  void at(const double* t, std::size_t n, std::size_t stride, double* q) const;

  // Of multiplier * q[column] + offset, where no part covers the column.
  NumberBound bound(std::int32_t column, double multiplier, double offset) const {
    const double a = multiplier * q0_[at_column(column)], b = multiplier * q1_[at_column(column)];
    return {std::fabs(b - a), larger(std::fabs(a + offset), std::fabs(b + offset))};
  }
  // Of the part that begins at a column.
  Rate bound(std::int32_t column) const;
  // The larger magnitude of a column at both ends. Between them the position of a planar or floating joint may get
  // three times as far (plannercheck/motions/joint_drives.py).
  double size(std::size_t column) const { return larger(std::fabs(q0_[column]), std::fabs(q1_[column])); }
  // The largest of all columns; how far any circle or quaternion of the given numbers is off length 1.
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

  static std::size_t at_column(std::int32_t column) { return static_cast<std::size_t>(column); }
  void set_part(std::size_t part);
  void part_at(std::size_t part, double t, double* q, std::size_t stride) const;
};

}  // namespace plannercheck
