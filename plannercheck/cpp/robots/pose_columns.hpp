// A pose by its columns: three of the rotation and the translation, each with a fourth lane that starts as zero; and
// the moves of a pose, by the operations of lane_pose.hpp.
#pragma once

#include <array>
#include <cstddef>

#include "math/double4.hpp"
#include "math/shuffle.hpp"
#include "math/vec.hpp"

namespace plannercheck {

struct PoseColumns {
  Double4 column[4];

  double at(std::size_t row, std::size_t col) const { return column[col][row]; }

  // By a rotation, whose rows are `step` numbers apart.
  void rotate(const double* r, std::size_t step) {
    const Double4 a = column[0], b = column[1], c = column[2];
    for (std::size_t k = 0; k < 3; ++k) column[k] = a * r[k] + b * r[step + k] + c * r[2 * step + k];
  }
  void rotate(const std::array<double, 9>& r) { rotate(r.data(), 3); }

  void slide(double x, double y, double z) { column[3] = column[0] * x + column[1] * y + column[2] * z + column[3]; }

  // By the angle of (cos, sin) that takes column `from` towards column `to`.
  template <std::size_t from, std::size_t to>
  void turn(double cos, double sin) {
    const Double4 a = column[from], b = column[to];
    column[from] = cos * a + sin * b;
    column[to] = cos * b - sin * a;
  }

  // The pose by rows.
  Pose by_rows() const {
    const Double4 low = shuffled<0, 4, 1, 5>(column[0], column[1]), high = shuffled<0, 4, 1, 5>(column[2], column[3]);
    const Double4 third = shuffled<2, 6, 3, 7>(column[0], column[1]), last = shuffled<2, 6, 3, 7>(column[2], column[3]);
    Pose out;
    store_double4(out.m.data(), shuffled<0, 1, 4, 5>(low, high));
    store_double4(out.m.data() + 4, shuffled<2, 3, 6, 7>(low, high));
    store_double4(out.m.data() + 8, shuffled<0, 1, 4, 5>(third, last));
    return out;
  }
};

// A link's pose times a placement on it, by the operations of the other `placed_on` (broad_phase/geometry_object.hpp).
inline Pose placed_on(const PoseColumns& link, const Pose& placement) {
  const auto& p = placement.m;
  const Double4* const c = link.column;
  PoseColumns out;
  for (std::size_t j = 0; j < 4; ++j) out.column[j] = (c[0] * p[j] + c[1] * p[j + 4]) + c[2] * p[j + 8];
  out.column[3] += c[3];
  return out.by_rows();
}

inline PoseColumns columns_of(const double* rows) {
  PoseColumns out;
  for (std::size_t k = 0; k < 4; ++k) out.column[k] = Double4{rows[k], rows[4 + k], rows[8 + k], 0};
  return out;
}

}  // namespace plannercheck
