// Signs of polynomials of doubles, exact: a filter in doubles, then double-double, then dyadic numbers.
#pragma once

#include "math/dyadic.hpp"
#include "math/vec.hpp"

namespace plannercheck {

inline constexpr double kRoundoff = 0x1p-53;  // u, half the distance of 1 to the next double

namespace predicates_detail {

// Filters in doubles are trusted only in this range, where products of up to three factors neither overflow nor lose
// bits to underflow that the error bound does not count (2^-1074 times the largest factors is far below the bound).
inline constexpr double kSmallestTrusted = 1e-150, kLargestTrusted = 1e60;

// The error of u · (a − b), as a part of the sum of its terms' absolute values: a rounded difference, product and two
// sums, 4u.
inline constexpr double kAlongError = 6 * kRoundoff;

inline bool trusted(double permanent, double largest) {
  return permanent > kSmallestTrusted && largest < kLargestTrusted;
}

inline double absolute_dot(Vec3 a, Vec3 b) {
  return std::fabs(a.x * b.x) + std::fabs(a.y * b.y) + std::fabs(a.z * b.z);
}

}  // namespace predicates_detail

// Sign of det(b − a, c − a, d − a): positive if d lies on the side from which a, b, c turn counter-clockwise.
int orientation(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Sign of u · (a − b): which of two points is further along u.
int compare_along_finer(Vec3 u, Vec3 a, Vec3 b);

// As above, with the filter inlined into queries.
inline int compare_along(Vec3 u, Vec3 a, Vec3 b) {
  const Vec3 e = a - b;
  const double value = dot(u, e), size = predicates_detail::absolute_dot(u, e);
  const bool in_range = predicates_detail::trusted(size, larger(norm_max(u), norm_max(e)));
  if (in_range && std::fabs(value) > predicates_detail::kAlongError * size) return value > 0 ? 1 : -1;
  return compare_along_finer(u, a, b);
}

// Sign of det(z, (a − v) × (b − v), u): on which side of the plane through z and the normal of the facet v a b u lies.
int wedge_side(Vec3 z, Vec3 v, Vec3 a, Vec3 b, Vec3 u);

// Sign of det(u, a − o, b − o): on which side of the plane through o, a, b the direction u points.
int cone_side(Vec3 u, Vec3 o, Vec3 a, Vec3 b);

// Sign of the component of (b − a) × (c − a) along an axis: the turn a, b, c of the projection along it.
int turn(Vec3 a, Vec3 b, Vec3 c, int axis);

// Whether a, b, c lie on a line.
bool collinear(Vec3 a, Vec3 b, Vec3 c);

}  // namespace plannercheck
