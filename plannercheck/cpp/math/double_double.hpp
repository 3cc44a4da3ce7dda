// Double-double arithmetic: unevaluated sums of two doubles.
#pragma once

#include "math/vec.hpp"

namespace plannercheck {

// A product errs by less than this part of itself, a sum of a and b by less than this part of |a| + |b|.
inline constexpr double kDoubleDoubleError = 0x1p-102;

// An unevaluated sum high + low, |low| <= u |high|.
struct DoubleDouble {
  double high, low;
};

inline DoubleDouble quick_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

inline DoubleDouble two_sum(double a, double b) {
  const double sum = a + b, b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

inline DoubleDouble two_product(double a, double b) {
  const double product = a * b;
#if defined(__FMA__) || defined(__aarch64__)
  return {product, __builtin_fma(a, b, -product)};
#else
  const double a_scaled = 134217729.0 * a, b_scaled = 134217729.0 * b;  // 2^27 + 1: Dekker's split
  const double a_high = a_scaled - (a_scaled - a), b_high = b_scaled - (b_scaled - b);
  const double a_low = a - a_high, b_low = b - b_high;
  return {product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)};
#endif
}

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  DoubleDouble high = two_sum(a.high, b.high);
  const DoubleDouble low = two_sum(a.low, b.low);
  high = quick_two_sum(high.high, high.low + low.high);
  return quick_two_sum(high.high, high.low + low.low);
}

inline DoubleDouble operator-(DoubleDouble a) { return {-a.high, -a.low}; }
inline DoubleDouble operator-(DoubleDouble a, DoubleDouble b) { return a + -b; }

inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble product = two_product(a.high, b.high);
  return quick_two_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

inline bool positive(DoubleDouble x) { return x.high > 0; }

struct DoubleDoubleVec3 {
  DoubleDouble x, y, z;
};
template <>
inline constexpr bool is_vector<DoubleDoubleVec3> = true;

inline DoubleDoubleVec3 difference(Vec3 a, Vec3 b) {
  return {two_sum(a.x, -b.x), two_sum(a.y, -b.y), two_sum(a.z, -b.z)};
}
inline DoubleDoubleVec3 widen(Vec3 a) { return {{a.x, 0}, {a.y, 0}, {a.z, 0}}; }
inline Vec3 rounded(const DoubleDoubleVec3& v) { return {v.x.high, v.y.high, v.z.high}; }

}  // namespace plannercheck
