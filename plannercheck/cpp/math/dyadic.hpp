// Exact numbers m · 2^e with an integer m of any length. Every double is one, and sums and products stay exact, so the
// sign of any polynomial of doubles can be computed. Slow: only for what the filters leave open.
//
// Exponents are multiples of the digits' 64 bits, so that sums need no shifts.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "math/double_double.hpp"
#include "math/limbs.hpp"
#include "math/vec.hpp"

namespace plannercheck {

class Dyadic {
 public:
  Dyadic() = default;
  Dyadic(double value);  // NOLINT(google-explicit-constructor): doubles are dyadic numbers; `value` must be finite

  int sign() const { return sign_; }
  // The double nearest to the number times 2^shift; overflows to infinity, and errs by 2^-1074 below 2^-1022.
  double to_double(std::int64_t shift = 0) const;
  // Exponent of the leading bit; meaningless for 0.
  std::int64_t log2() const;
  Dyadic shifted_by_limbs(std::int64_t limbs) const;  // times 2^(64 limbs)
  // The number is hexadecimal() · 2^exponent().
  std::string hexadecimal() const;
  std::int64_t exponent() const;

  friend Dyadic operator+(const Dyadic& a, const Dyadic& b) { return sum(a, b, b.sign_); }
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return sum(a, b, -b.sign_); }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b);
  Dyadic operator-() const;

 private:
  int sign_ = 0;
  std::int64_t position_ = 0;  // of the lowest digit: it counts 2^(64 position)
  Limbs limbs_;                // neither the first nor the last is 0

  std::int64_t end() const { return position_ + static_cast<std::int64_t>(limbs_.size()); }
  // The digit that counts 2^(64 position).
  std::uint64_t digit(std::int64_t position) const {
    return position < position_ || position >= end() ? 0 : limbs_[static_cast<std::size_t>(position - position_)];
  }
  void trim();
  static int compare_magnitudes(const Dyadic& a, const Dyadic& b);
  static Dyadic sum_of_magnitudes(const Dyadic& a, const Dyadic& b);
  static Dyadic difference_of_magnitudes(const Dyadic& larger, const Dyadic& smaller);
  // a + b, where b takes the given sign.
  static Dyadic sum(const Dyadic& a, const Dyadic& b, int sign_of_b);
};

struct DyadicVec3 {
  Dyadic x, y, z;

  DyadicVec3() = default;
  DyadicVec3(Dyadic x_, Dyadic y_, Dyadic z_) : x(std::move(x_)), y(std::move(y_)), z(std::move(z_)) {}
  explicit DyadicVec3(Vec3 v) : x(v.x), y(v.y), z(v.z) {}
  explicit DyadicVec3(const DoubleDoubleVec3& v)
      : x(Dyadic(v.x.high) + Dyadic(v.x.low)),
        y(Dyadic(v.y.high) + Dyadic(v.y.low)),
        z(Dyadic(v.z.high) + Dyadic(v.z.low)) {}
};

DyadicVec3 operator+(const DyadicVec3& a, const DyadicVec3& b);
DyadicVec3 operator-(const DyadicVec3& a, const DyadicVec3& b);
DyadicVec3 operator-(const DyadicVec3& a);
DyadicVec3 operator*(const Dyadic& s, const DyadicVec3& a);
Dyadic dot(const DyadicVec3& a, const DyadicVec3& b);
DyadicVec3 cross(const DyadicVec3& a, const DyadicVec3& b);
bool is_zero(const DyadicVec3& v);
// Up to a relative error of 2^-106, or 2^-1074; infinite beyond the range of doubles.
DoubleDouble to_double_double(const Dyadic& x);
// M v + t, and Mᵀ d, exactly.
DyadicVec3 apply_exactly(const Pose& pose, Vec3 v);
DyadicVec3 rotate_back_exactly(const Pose& pose, const DyadicVec3& d);
// The double nearest to a quotient whose divisor is positive; of two as near, the even one.
double nearest_quotient(const Dyadic& a, const Dyadic& b);
// The same direction up to a relative error of 2^-105 an entry, its largest entry scaled to between 1/2 and 1; 0 for 0.
// Entries below 2^-900 of the largest err by up to 2^-1073 instead.
DoubleDoubleVec3 direction_of(const DyadicVec3& v);

}  // namespace plannercheck
