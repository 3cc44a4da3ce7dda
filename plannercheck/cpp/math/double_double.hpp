// Double-double arithmetic: unevaluated sums of two doubles.
#pragma once

#include "math/vec.hpp"

namespace plannercheck {

// A product errs by less than this part of it, a sum of a and b by less than this part of |a| + |b|.
inline constexpr double kDouble2Error = 0x1p-102;

// An unevaluated sum high + low, |low| <= u |high|.
struct Double2 {
  double high, low;
};

inline Double2 quick_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

inline Double2 two_sum(double a, double b) {
  const double sum = a + b, b_part = sum - a;
  return {sum, (a - (sum - b_part)) + (b - b_part)};
}

inline Double2 two_product(double a, double b) {
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

inline Double2 operator+(Double2 a, Double2 b) {
  Double2 high = two_sum(a.high, b.high);
  const Double2 low = two_sum(a.low, b.low);
  high = quick_two_sum(high.high, high.low + low.high);
  return quick_two_sum(high.high, high.low + low.low);
}

inline Double2 operator-(Double2 a) { return {-a.high, -a.low}; }
inline Double2 operator-(Double2 a, Double2 b) { return a + -b; }

inline Double2 operator*(Double2 a, Double2 b) {
  const Double2 product = two_product(a.high, b.high);
  return quick_two_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

inline bool positive(Double2 x) { return x.high > 0; }

struct Double2Vec3 {
  Double2 x, y, z;
};

inline Double2Vec3 difference(Vec3 a, Vec3 b) { return {two_sum(a.x, -b.x), two_sum(a.y, -b.y), two_sum(a.z, -b.z)}; }
inline Double2Vec3 widen(Vec3 a) { return {{a.x, 0}, {a.y, 0}, {a.z, 0}}; }
inline Vec3 rounded(const Double2Vec3& v) { return {v.x.high, v.y.high, v.z.high}; }

inline Double2Vec3 operator+(const Double2Vec3& a, const Double2Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Double2Vec3 operator-(const Double2Vec3& a, const Double2Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Double2Vec3 operator-(const Double2Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Double2Vec3 operator*(Double2 s, const Double2Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }

inline Double2Vec3 cross(const Double2Vec3& a, const Double2Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline Double2 dot(const Double2Vec3& a, const Double2Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

}  // namespace plannercheck
