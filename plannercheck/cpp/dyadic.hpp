// Exact numbers m · 2^e with an integer m of any length. Every double is one, and sums and products stay exact, so
// the sign of any polynomial of doubles can be had. Slow (it allocates): only for what the filters leave over.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vec.hpp"

namespace plannercheck {

class Dyadic {
 public:
  Dyadic() = default;
  Dyadic(double value);  // NOLINT(google-explicit-constructor): doubles are dyadic numbers; `value` must be finite

  int sign() const { return sign_; }
  // Nearest double up to a relative error of 2^-52; overflows to infinity and underflows to 0.
  double to_double() const;
  // Exponent of the leading bit; meaningless for 0.
  std::int64_t log2() const;
  Dyadic shifted(std::int64_t bits) const;  // times 2^bits
  // The number is hexadecimal() · 2^exponent().
  std::string hexadecimal() const;
  std::int64_t exponent() const { return exponent_; }

  friend Dyadic operator+(const Dyadic& a, const Dyadic& b);
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return a + -b; }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b);
  Dyadic operator-() const;

 private:
  int sign_ = 0;
  std::int64_t exponent_ = 0;
  std::vector<std::uint32_t> limbs_;  // little endian, no leading zero limb

  void trim();
};

struct DyadicVec3 {
  Dyadic x, y, z;

  DyadicVec3() = default;
  DyadicVec3(Dyadic x_, Dyadic y_, Dyadic z_) : x(std::move(x_)), y(std::move(y_)), z(std::move(z_)) {}
  explicit DyadicVec3(Vec3 v) : x(v.x), y(v.y), z(v.z) {}
};

DyadicVec3 operator+(const DyadicVec3& a, const DyadicVec3& b);
DyadicVec3 operator-(const DyadicVec3& a, const DyadicVec3& b);
DyadicVec3 operator*(const Dyadic& s, const DyadicVec3& a);
Dyadic dot(const DyadicVec3& a, const DyadicVec3& b);
DyadicVec3 cross(const DyadicVec3& a, const DyadicVec3& b);
// M v + t, exactly.
DyadicVec3 apply_exactly(const Pose& pose, Vec3 v);
// Doubles in about the same direction, the largest component scaled to between 1/2 and 1; 0 for 0.
Vec3 direction_of(const DyadicVec3& v);

}  // namespace plannercheck
