// Integers of any size, with sums, differences, products and signs.
//
// Written for the oracle alone: it shares no line with the core's exact arithmetic (dyadic.hpp, limbs.hpp).
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plannercheck::oracle {

class Integer {
 public:
  Integer() = default;
  // value · 2^shift
  explicit Integer(__int128 value, std::size_t shift = 0);
  // Hexadecimal digits with an optional sign; throws std::invalid_argument.
  explicit Integer(const std::string& hexadecimal);

  int sign() const { return magnitude_.empty() ? 0 : negative_ ? -1 : 1; }
  // Number of bits of the absolute value, without leading zeros.
  std::size_t bits() const;
  // value / 2^scale cut off after 53 leading bits; 0 if too small for a double.
  double over_power_of_two(std::int64_t scale) const;
  std::string hexadecimal() const;

  Integer operator-() const;
  Integer operator<<(std::size_t shift) const;
  friend Integer operator+(const Integer& a, const Integer& b) { return a.plus(b, b.negative_); }
  friend Integer operator-(const Integer& a, const Integer& b) { return a.plus(b, !b.negative_); }
  friend Integer operator*(const Integer& a, const Integer& b);
  friend bool operator==(const Integer& a, const Integer& b) = default;
  friend std::strong_ordering operator<=>(const Integer& a, const Integer& b) { return (a - b).sign() <=> 0; }

 private:
  using Magnitude = std::vector<std::uint64_t>;  // digits of base 2^64, the least first, no leading 0

  bool negative_ = false;  // never of 0
  Magnitude magnitude_;

  void shed_zeros();
  // This number plus the other's absolute value, which `negative` gives its sign.
  Integer plus(const Integer& other, bool negative) const;
};

struct Vector {
  Integer x, y, z;
};

Vector operator+(const Vector& a, const Vector& b);
Vector operator-(const Vector& a, const Vector& b);
Vector operator-(const Vector& a);
Vector operator*(const Integer& s, const Vector& a);
Integer dot(const Vector& a, const Vector& b);
Vector cross(const Vector& a, const Vector& b);
bool is_zero(const Vector& a);

}  // namespace plannercheck::oracle
