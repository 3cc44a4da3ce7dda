// The path of a motion: all that knows which curve the numbers of a motion define.
//
// In: which columns of a configuration form a circle, a quaternion, or a pose; a motion's numbers, which are two
// configurations or the control points of a curve. Out: the configuration at any parameter in [0, 1]; bounds, on an
// interval, of each number and of how fast each part turns and slides. Idea: on a straight motion every joint moves
// along a constant twist (a screw), as Pinocchio's `interpolate` does: angles and lengths linearly, a (cosine, sine)
// the short way round, a quaternion by slerp, planar and floating joints by the exponential of one twist. So no second
// derivative of an angle or a length counts, and the bounds of an interval are those of the whole path.
//
// On a curve, angles and lengths are polynomials by their Bernstein coefficients, the control points b[0] … b[n]: on an
// interval of length h, which de Casteljau's algorithm cuts out, they lie between the least and the largest b[k], their
// derivatives are at most n max |b[k + 1] − b[k]| / h and n (n − 1) max |b[k + 2] − 2 b[k + 1] + b[k]| / h². Parts move
// between the first and the last control point as on a straight motion.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

// The numbers of a motion: its ends. A curve, whose degree is above 1, has its control points in rows from `start` to
// `end`. `tube`: by how much each number may be off at every parameter, and then how far bodies have to stay apart, m;
// null for none.
struct Segment {
  const double *start, *end;
  std::size_t degree = 1;
  const double* tube = nullptr;
};

// The numbers of several motions, `stride` numbers from one to the next, and `tube_stride` from one tube to the next.
struct Segments {
  const double *starts, *ends;
  std::size_t stride, degree = 1;
  const double* tubes = nullptr;
  std::size_t tube_stride = 0;

  Segment operator[](std::size_t i) const {
    return {starts + i * stride, ends + i * stride, degree, tubes == nullptr ? nullptr : tubes + i * tube_stride};
  }
  Segments from(std::size_t first) const {
    const Segment at_first = (*this)[first];
    return {at_first.start, at_first.end, stride, degree, at_first.tube, tube_stride};
  }
};

// The highest degree of a curve.
inline constexpr std::size_t kMostDegree = 31;

// Whether each of n numbers stays between bounds on a motion, its tube included; numbers of unit vectors are at most 1
// and do not count.
inline bool stays_within(const Segment& motion, std::size_t n, const double* low, const double* high) {
  const double* const tube = motion.tube;
  const auto is_within = [&](const double* row) {
    for (std::size_t c = 0; c < n && tube == nullptr; ++c) {
      if (!(row[c] >= low[c] && row[c] <= high[c])) return false;
    }
    for (std::size_t c = 0; c < n && tube != nullptr; ++c) {
      if (!(row[c] - tube[c] >= low[c] && row[c] + tube[c] <= high[c])) return false;
    }
    return true;
  };
  for (std::size_t k = 0; k < motion.degree; ++k) {
    if (!is_within(motion.start + k * n)) return false;
  }
  return is_within(motion.end);
}

// How much a number that no part covers changes on a straight motion.
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

  std::size_t width() const { return kind == PartKind::kCircle ? 2 : kind == PartKind::kFree ? 7 : 4; }
};

// Bounds of how fast a part or joint turns (rad) and slides (m) by the parameter, and of its largest distance from its
// origin (m).
struct Rate {
  double turn = 0, slide = 0, extent = 0;
};

// Bounds of a number's derivative by the parameter, and of its magnitude.
struct NumberBound {
  double rate, size;
};

class Path {
 public:
  Path(std::size_t width, std::vector<PathPart> parts);

  // Columns that no part covers are interpolated linearly, or follow their control points; for continuous joints the
  // caller chooses the short way. Bounds are those of the whole path. `thin_tubes`: whether a tube as thin as rounding
  // counts as rounding.
  void set(const Segment& motion, bool thin_tubes = true);
  // From here on, bounds hold on this interval of a curve.
  void look_at(double from, double to);

  bool is_curve() const { return degree_ > 1; }
  bool has_tube() const { return !tube_.empty(); }
  double room() const { return room_; }

  // Configurations at n parameters, column by column: q[column * stride + i].
  void at(const double* t, std::size_t n, std::size_t stride, double* q) const;

  // The bound of multiplier * q[column] + offset, for a column that no part covers.
  NumberBound bound(std::int32_t column, double multiplier, double offset) const {
    if (is_curve()) return bound_of_curve(at_column(column), multiplier, offset);
    const double a = multiplier * q0_[at_column(column)], b = multiplier * q1_[at_column(column)];
    return {std::fabs(b - a), larger(std::fabs(a + offset), std::fabs(b + offset))};
  }
  // On a curve: how fast the derivative of multiplier * q[column] changes.
  double change(std::int32_t column, double multiplier) const {
    return std::fabs(multiplier) * on_curve_[at_column(column)].change;
  }
  // The bounds of the part that begins at a column.
  Rate bound(std::int32_t column) const;
  // By how much a number may be off.
  double tube(std::int32_t column) const { return has_tube() ? tube_[at_column(column)] : 0; }
  // The larger magnitude of a column at both ends, or of all control points, with the tube. Between them the position
  // of a planar or floating joint may get three times as far (plannercheck/motions/joint_drives.py).
  double size(std::size_t column) const { return sizes_[column]; }
  // The largest of all columns; how far any circle or quaternion of the given numbers is off length 1.
  double largest() const { return largest_; }
  double off_unit() const { return off_unit_; }
  // By how much the numbers of `at` may be off, by rounding and a thin tube.
  double number_error() const {
    const double roundings = is_curve() ? 16 + 4 * static_cast<double>(degree_) : 16;
    return roundings * 0x1p-53 * (1 + largest()) + off_curve_;
  }

 private:
  struct Twist {
    Vec3 turn, slide;  // in the moving frame
    double angle = 0;  // |turn|
  };

  // The bounds of a number on the current interval.
  struct CurveBound {
    double low, high, rate, change;
  };

  std::vector<double> q0_, q1_, sizes_, tube_;
  std::size_t degree_ = 1;
  std::vector<double> control_;       // rows of all columns
  std::vector<double> cut_;           // of the interval that is looked at
  std::vector<CurveBound> on_curve_;  // by column
  std::vector<PathPart> parts_;
  std::vector<Twist> twists_;
  std::vector<std::int32_t> linear_;  // columns that no part covers
  double largest_ = 0, off_unit_ = 0, room_ = 0, off_curve_ = 0;

  static std::size_t at_column(std::int32_t column) { return static_cast<std::size_t>(column); }
  NumberBound bound_of_curve(std::size_t column, double multiplier, double offset) const {
    const CurveBound& on = on_curve_[column];
    const double a = multiplier * on.low + offset, b = multiplier * on.high + offset;
    return {std::fabs(multiplier) * on.rate, larger(std::fabs(a), std::fabs(b))};
  }
  void set_tube(const double* tube, bool thin_tubes);
  void cut_up_to(double place);
  void cut_from(double place);
  void curve_at(const double* t, std::size_t n, std::size_t stride, double* q) const;
  void set_part(std::size_t part);
  void part_at(std::size_t part, double t, double* q, std::size_t stride) const;
};

}  // namespace plannercheck
