#include "oracle/integer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace plannercheck::oracle {
namespace {

using Wide = unsigned __int128;
constexpr std::size_t kDigitBits = 64;

// Compares digits: −1, 0 or 1 as the first number is smaller, equal or larger.
int compared(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  for (std::size_t i = a.size(); i-- > 0;) {
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  }
  return 0;
}

std::vector<std::uint64_t> sum(const std::vector<std::uint64_t>& longer, const std::vector<std::uint64_t>& shorter) {
  std::vector<std::uint64_t> out(longer.size() + 1);
  Wide carry = 0;
  for (std::size_t i = 0; i < longer.size(); ++i) {
    carry += Wide{longer[i]} + (i < shorter.size() ? shorter[i] : 0);
    out[i] = static_cast<std::uint64_t>(carry);
    carry >>= kDigitBits;
  }
  out.back() = static_cast<std::uint64_t>(carry);
  return out;
}

// The first number has to be at least the second.
std::vector<std::uint64_t> difference(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  std::vector<std::uint64_t> out(a.size());
  std::uint64_t borrow = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Wide taken = Wide{i < b.size() ? b[i] : 0} + borrow;
    borrow = Wide{a[i]} < taken ? 1 : 0;
    out[i] = static_cast<std::uint64_t>(Wide{a[i]} - taken);
  }
  return out;
}

}  // namespace

Integer::Integer(__int128 value, std::size_t shift) : negative_(value < 0) {
  const Wide size = value < 0 ? -static_cast<Wide>(value) : static_cast<Wide>(value);
  magnitude_ = {static_cast<std::uint64_t>(size), static_cast<std::uint64_t>(size >> kDigitBits)};
  shed_zeros();
  if (shift > 0) *this = *this << shift;
}

Integer::Integer(const std::string& hexadecimal) {
  const bool negative = !hexadecimal.empty() && hexadecimal[0] == '-';
  const std::string digits = hexadecimal.substr(negative ? 1 : 0);
  if (digits.empty() || digits.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw std::invalid_argument("hexadecimal digits are expected, not '" + hexadecimal + "'");
  constexpr std::size_t kLetters = kDigitBits / 4;
  for (std::size_t end = digits.size(); end > 0; end -= std::min(end, kLetters)) {
    const std::size_t start = end - std::min(end, kLetters);
    magnitude_.push_back(std::stoull(digits.substr(start, end - start), nullptr, 16));
  }
  negative_ = negative;
  shed_zeros();
}

void Integer::shed_zeros() {
  while (!magnitude_.empty() && magnitude_.back() == 0) magnitude_.pop_back();
  if (magnitude_.empty()) negative_ = false;
}

std::size_t Integer::bits() const {
  return magnitude_.empty()
             ? 0
             : kDigitBits * magnitude_.size() - static_cast<std::size_t>(std::countl_zero(magnitude_.back()));
}

double Integer::over_power_of_two(std::int64_t scale) const {
  if (magnitude_.empty()) return 0;
  const std::size_t top = magnitude_.size() - 1;
  const auto zeros = static_cast<std::size_t>(std::countl_zero(magnitude_[top]));
  std::uint64_t leading = magnitude_[top] << zeros;
  if (zeros > 0 && top > 0) leading |= magnitude_[top - 1] >> (kDigitBits - zeros);
  const auto exponent = static_cast<std::int64_t>(kDigitBits * top) - static_cast<std::int64_t>(zeros) - scale + 11;
  const double size =
      std::ldexp(static_cast<double>(leading >> 11), static_cast<int>(std::clamp<std::int64_t>(exponent, -4000, 4000)));
  return negative_ ? -size : size;
}

std::string Integer::hexadecimal() const {
  if (magnitude_.empty()) return "0";
  std::string letters;
  for (const std::uint64_t digit : magnitude_) {
    for (std::size_t k = 0; k < kDigitBits; k += 4) letters.push_back("0123456789abcdef"[digit >> k & 15U]);
  }
  while (letters.back() == '0') letters.pop_back();
  if (negative_) letters.push_back('-');
  return {letters.rbegin(), letters.rend()};
}

Integer Integer::operator-() const {
  Integer out = *this;
  out.negative_ = !negative_ && !magnitude_.empty();
  return out;
}

Integer Integer::operator<<(std::size_t shift) const {
  if (magnitude_.empty()) return {};
  const std::size_t whole = shift / kDigitBits, part = shift % kDigitBits;
  Integer out;
  out.negative_ = negative_;
  out.magnitude_.assign(magnitude_.size() + whole + 1, 0);
  for (std::size_t i = 0; i < magnitude_.size(); ++i) {
    const Wide moved = Wide{magnitude_[i]} << part;
    out.magnitude_[i + whole] |= static_cast<std::uint64_t>(moved);
    out.magnitude_[i + whole + 1] = static_cast<std::uint64_t>(moved >> kDigitBits);
  }
  out.shed_zeros();
  return out;
}

Integer Integer::plus(const Integer& other, bool negative) const {
  Integer out;
  if (negative_ == negative || magnitude_.empty() || other.magnitude_.empty()) {
    const bool longer = magnitude_.size() >= other.magnitude_.size();
    out.magnitude_ = longer ? sum(magnitude_, other.magnitude_) : sum(other.magnitude_, magnitude_);
    out.negative_ = magnitude_.empty() ? negative : negative_;
  } else {
    const int order = compared(magnitude_, other.magnitude_);
    if (order == 0) return out;
    out.magnitude_ = order > 0 ? difference(magnitude_, other.magnitude_) : difference(other.magnitude_, magnitude_);
    out.negative_ = order > 0 ? negative_ : negative;
  }
  out.shed_zeros();
  return out;
}

Integer operator*(const Integer& a, const Integer& b) {
  Integer out;
  if (a.magnitude_.empty() || b.magnitude_.empty()) return out;
  out.negative_ = a.negative_ != b.negative_;
  out.magnitude_.assign(a.magnitude_.size() + b.magnitude_.size(), 0);
  for (std::size_t i = 0; i < a.magnitude_.size(); ++i) {
    Wide carry = 0;
    for (std::size_t j = 0; j < b.magnitude_.size(); ++j) {
      carry += Wide{a.magnitude_[i]} * b.magnitude_[j] + out.magnitude_[i + j];
      out.magnitude_[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= kDigitBits;
    }
    out.magnitude_[i + b.magnitude_.size()] = static_cast<std::uint64_t>(carry);
  }
  out.shed_zeros();
  return out;
}

Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator-(const Vector& a) { return {-a.x, -a.y, -a.z}; }
Vector operator*(const Integer& s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
Integer dot(const Vector& a, const Vector& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
bool is_zero(const Vector& a) { return a.x.sign() == 0 && a.y.sign() == 0 && a.z.sign() == 0; }

}  // namespace plannercheck::oracle
