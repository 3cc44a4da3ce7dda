// Whole numbers of any size, of which the oracle knows sums, differences, products and signs.
//
// Written for the oracle alone: the core's exact arithmetic (dyadic.hpp, limbs.hpp) has no line in common with it.
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
  // Hexadecimal digits, after a sign or none; throws std::invalid_argument.
  explicit Integer(const std::string& hexadecimal);

  int sign() const { return magnitude_.empty() ? 0 : negative_ ? -1 : 1; }
  // Of the absolute value, without leading zeros.
  std::size_t bits() const;
  // About value / 2^scale: its 53 leading bits, cut off; what is too small for a double is 0.
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
  // This number plus the other's absolute value, counted as negative or not.
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
