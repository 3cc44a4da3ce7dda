// Poses of several states at once, and how they are placed and turned: elementwise on lanes of doubles or of floats.
//
// A pose is twelve numbers `m` of a row-major 3x4 matrix, each in all lanes. Idea: a chain's pose stays in registers
// from joint to joint. So all of this changes a pose in place, row by row, and is inlined into the loop over joints.
#pragma once

#include <cstddef>

#include "math/simd.hpp"
#include "robots/kinematics.hpp"

namespace plannercheck {

// ----- placements: p, a row-major 3x4 matrix of single numbers

// x a + y b + z c, from the left.
template <class Numbers, class Number>
inline Numbers product(Numbers x, Numbers y, Numbers z, Number a, Number b, Number c) {
  return dot_of(x, y, z, filled<Numbers>(a), filled<Numbers>(b), filled<Numbers>(c));
}

// The translation of a row's pose times a placement.
template <class Numbers, class Number>
inline Numbers placed_origin(const Numbers* row, const Number* p) {
  return product(row[0], row[1], row[2], p[3], p[7], p[11]) + row[3];
}

template <class Numbers, class Number>
inline void place_anyhow(Numbers* m, const Number* p) {
#pragma GCC unroll 3
  for (std::size_t k = 0; k < 3; ++k) {
    Numbers* const row = m + 4 * k;
    const Numbers origin = placed_origin(row, p), a = row[0], b = row[1], c = row[2];
#pragma GCC unroll 3
    for (std::size_t col = 0; col < 3; ++col) row[col] = product(a, b, c, p[col], p[4 + col], p[8 + col]);
    row[3] = origin;
  }
}

// By a placement whose rotation is the identity.
template <class Numbers, class Number>
inline void place_shifted(Numbers* m, const Number* p) {
#pragma GCC unroll 3
  for (std::size_t k = 0; k < 3; ++k) m[4 * k + 3] = placed_origin(m + 4 * k, p);
}

// By a placement whose rotation keeps one axis.
template <std::size_t axis, class Numbers, class Number>
inline void place_turned(Numbers* m, const Number* p) {
  constexpr std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
#pragma GCC unroll 3
  for (std::size_t k = 0; k < 3; ++k) {
    Numbers* const row = m + 4 * k;
    const Numbers origin = placed_origin(row, p), a = row[i], b = row[j];
    row[i] = multiply_add(b, filled<Numbers>(p[4 * j + i]), a * p[4 * i + i]);
    row[j] = multiply_add(b, filled<Numbers>(p[4 * j + j]), a * p[4 * i + j]);
    row[3] = origin;
  }
}

// A pose times a placement.
template <class Numbers, class Number>
[[gnu::always_inline]] inline void place(Numbers* m, PlacementForm form, const Number* p) {
  switch (form) {
    case PlacementForm::kIdentity:
      return;
    case PlacementForm::kShift:
      return place_shifted(m, p);
    case PlacementForm::kTurnX:
      return place_turned<0>(m, p);
    case PlacementForm::kTurnY:
      return place_turned<1>(m, p);
    case PlacementForm::kTurnZ:
      return place_turned<2>(m, p);
    case PlacementForm::kGeneral:
      return place_anyhow(m, p);
  }
}

// ----- motions of joints

// A pose times the rotation by the angle of (cos, sin) that takes column `from` towards column `to`.
template <std::size_t from, std::size_t to, class Numbers>
inline void turn_columns(Numbers* m, Numbers cos, Numbers sin) {
#pragma GCC unroll 3
  for (std::size_t row = 0; row < 3; ++row) {
    const Numbers a = m[4 * row + from], b = m[4 * row + to];
    m[4 * row + from] = multiply_add(cos, a, sin * b);
    m[4 * row + to] = multiply_subtract(cos, b, sin * a);
  }
}

}  // namespace plannercheck
