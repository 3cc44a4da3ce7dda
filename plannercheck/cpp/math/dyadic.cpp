#include "math/dyadic.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace plannercheck {
namespace {

__extension__ using Wide = unsigned __int128;
constexpr int kLimbBits = 64;
constexpr int kMantissaBits = 52;              // stored ones
constexpr std::int64_t kBias = 1075;           // of a double's exponent, its mantissa read as an integer
constexpr std::int64_t kExtreme = 4000;        // powers of two beyond are 0 or infinity as doubles
constexpr double kSmallestWithLow = 0x1p-900;  // the low part of smaller entries would underflow

std::int64_t floor_limbs(std::int64_t bits) { return bits >> 6; }

}  // namespace

Dyadic::Dyadic(double value) {
  if (value == 0) return;
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const auto biased = static_cast<std::int64_t>(bits >> kMantissaBits & 0x7ffU);
  std::uint64_t integer = bits & ((std::uint64_t{1} << kMantissaBits) - 1);
  if (biased > 0) integer |= std::uint64_t{1} << kMantissaBits;
  const std::int64_t exponent = (biased > 0 ? biased : 1) - kBias;
  const auto part = static_cast<int>(exponent & (kLimbBits - 1));
  const Wide wide = static_cast<Wide>(integer) << part;
  sign_ = value > 0 ? 1 : -1;
  position_ = floor_limbs(exponent);
  limbs_.reserve(2);
  limbs_[0] = static_cast<std::uint64_t>(wide);
  limbs_[1] = static_cast<std::uint64_t>(wide >> kLimbBits);
  trim();
}

void Dyadic::trim() {
  position_ += static_cast<std::int64_t>(limbs_.trim());
  if (limbs_.size() == 0) sign_ = 0, position_ = 0;
}

std::int64_t Dyadic::log2() const { return end() * kLimbBits - 1 - std::countl_zero(limbs_.back()); }

// Rounds once: the leading 64 bits, the last of which is set if any bit follows.
double Dyadic::to_double(std::int64_t shift) const {
  if (sign_ == 0) return 0;
  const int zeros = std::countl_zero(limbs_.back());
  const std::uint64_t next = digit(end() - 2);
  std::uint64_t leading = limbs_.back() << zeros;
  if (zeros > 0) leading |= next >> (kLimbBits - zeros);
  const bool more = limbs_.size() > 2 || (next << zeros) != 0;
  leading |= more ? 1U : 0U;
  const std::int64_t scale = log2() - (kLimbBits - 1) + shift;
  return sign_ * std::ldexp(static_cast<double>(leading), static_cast<int>(std::clamp(scale, -kExtreme, kExtreme)));
}

std::int64_t Dyadic::exponent() const { return position_ * kLimbBits; }

std::string Dyadic::hexadecimal() const {
  if (sign_ == 0) return "0";
  std::string digits;
  for (std::size_t i = 0; i < limbs_.size(); ++i) {
    for (int shift = 0; shift < kLimbBits; shift += 4) digits.push_back("0123456789abcdef"[limbs_[i] >> shift & 15U]);
  }
  while (digits.back() == '0') digits.pop_back();
  if (sign_ < 0) digits.push_back('-');
  return {digits.rbegin(), digits.rend()};
}

Dyadic Dyadic::operator-() const {
  Dyadic out = *this;
  out.sign_ = -out.sign_;
  return out;
}

Dyadic Dyadic::shifted_by_limbs(std::int64_t limbs) const {
  Dyadic out = *this;
  if (sign_ != 0) out.position_ += limbs;
  return out;
}

int Dyadic::compare_magnitudes(const Dyadic& a, const Dyadic& b) {
  if (a.end() != b.end()) return a.end() < b.end() ? -1 : 1;
  const std::int64_t lowest = std::min(a.position_, b.position_);
  for (std::int64_t k = a.end() - 1; k >= lowest; --k) {
    const std::uint64_t x = a.digit(k), y = b.digit(k);
    if (x != y) return x < y ? -1 : 1;
  }
  return 0;
}

Dyadic Dyadic::sum_of_magnitudes(const Dyadic& a, const Dyadic& b) {
  Dyadic out;
  out.position_ = std::min(a.position_, b.position_);
  const std::int64_t end = std::max(a.end(), b.end());
  out.limbs_.reserve(static_cast<std::size_t>(end - out.position_ + 1));
  std::uint64_t* to = out.limbs_.data();
  std::uint64_t carry = 0;
  for (std::int64_t k = out.position_; k < end; ++k) {
    const Wide wide = static_cast<Wide>(a.digit(k)) + b.digit(k) + carry;
    *to++ = static_cast<std::uint64_t>(wide);
    carry = static_cast<std::uint64_t>(wide >> kLimbBits);
  }
  *to = carry;
  return out;
}

Dyadic Dyadic::difference_of_magnitudes(const Dyadic& larger, const Dyadic& smaller) {
  Dyadic out;
  out.position_ = std::min(larger.position_, smaller.position_);
  out.limbs_.reserve(static_cast<std::size_t>(larger.end() - out.position_));
  std::uint64_t* to = out.limbs_.data();
  std::uint64_t borrow = 0;
  for (std::int64_t k = out.position_; k < larger.end(); ++k) {
    const Wide wide = static_cast<Wide>(larger.digit(k)) - smaller.digit(k) - borrow;
    *to++ = static_cast<std::uint64_t>(wide);
    borrow = static_cast<std::uint64_t>(wide >> kLimbBits) & 1U;
  }
  return out;
}

Dyadic Dyadic::sum(const Dyadic& a, const Dyadic& b, int sign_of_b) {
  if (b.sign_ == 0) return a;
  if (a.sign_ == 0) return sign_of_b == b.sign_ ? b : -b;
  const bool same = a.sign_ == sign_of_b;
  const int order = same ? 1 : compare_magnitudes(a, b);
  if (order == 0) return {};
  Dyadic out = same        ? sum_of_magnitudes(a, b)
               : order > 0 ? difference_of_magnitudes(a, b)
                           : difference_of_magnitudes(b, a);
  out.sign_ = order > 0 ? a.sign_ : sign_of_b;
  out.trim();
  return out;
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  if (a.sign_ == 0 || b.sign_ == 0) return {};
  Dyadic out;
  out.sign_ = a.sign_ * b.sign_;
  out.position_ = a.position_ + b.position_;
  out.limbs_.reserve(a.limbs_.size() + b.limbs_.size());
  std::uint64_t* const to = out.limbs_.data();
  const std::uint64_t *const x = a.limbs_.data(), *const y = b.limbs_.data();
  const std::size_t rows = a.limbs_.size(), columns = b.limbs_.size();
  std::fill_n(to, columns, 0);
  for (std::size_t i = 0; i < rows; ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < columns; ++j) {
      const Wide wide = static_cast<Wide>(x[i]) * y[j] + to[i + j] + carry;
      to[i + j] = static_cast<std::uint64_t>(wide);
      carry = static_cast<std::uint64_t>(wide >> kLimbBits);
    }
    to[i + columns] = carry;
  }
  out.trim();
  return out;
}

DyadicVec3 operator+(const DyadicVec3& a, const DyadicVec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
DyadicVec3 operator-(const DyadicVec3& a, const DyadicVec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
DyadicVec3 operator-(const DyadicVec3& a) { return {-a.x, -a.y, -a.z}; }
DyadicVec3 operator*(const Dyadic& s, const DyadicVec3& a) { return {s * a.x, s * a.y, s * a.z}; }
Dyadic dot(const DyadicVec3& a, const DyadicVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
DyadicVec3 cross(const DyadicVec3& a, const DyadicVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
bool is_zero(const DyadicVec3& v) { return v.x.sign() == 0 && v.y.sign() == 0 && v.z.sign() == 0; }

DoubleDouble to_double_double(const Dyadic& x) {
  const double high = x.to_double();
  return {high, std::isfinite(high) ? (x - Dyadic(high)).to_double() : 0};
}

DyadicVec3 apply_exactly(const Pose& pose, Vec3 v) {
  const auto& m = pose.m;
  const DyadicVec3 p(v);
  const auto row = [&](std::size_t i) {
    return Dyadic(m[i]) * p.x + Dyadic(m[i + 1]) * p.y + Dyadic(m[i + 2]) * p.z + Dyadic(m[i + 3]);
  };
  return {row(0), row(4), row(8)};
}

DyadicVec3 rotate_back_exactly(const Pose& pose, const DyadicVec3& d) {
  const auto column = [&](std::size_t j) {
    return Dyadic(pose.m[j]) * d.x + Dyadic(pose.m[j + 4]) * d.y + Dyadic(pose.m[j + 8]) * d.z;
  };
  return {column(0), column(1), column(2)};
}

double nearest_quotient(const Dyadic& a, const Dyadic& b) {
  if (a.sign() == 0) return 0;
  const std::int64_t scale_a = a.log2(), scale_b = b.log2();
  double nearest = std::ldexp(a.to_double(-scale_a) / b.to_double(-scale_b), static_cast<int>(scale_a - scale_b));
  const auto off = [&](double x) {
    const Dyadic out = a - Dyadic(x) * b;
    return out.sign() < 0 ? -out : out;
  };
  for (const double end : {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}) {
    for (;;) {
      const double x = std::nextafter(nearest, end);
      const int order = (off(x) - off(nearest)).sign();
      if (order > 0 || (order == 0 && (std::bit_cast<std::uint64_t>(x) & 1) != 0)) break;
      nearest = x;
    }
  }
  return nearest;
}

DoubleDoubleVec3 direction_of(const DyadicVec3& v) {
  std::int64_t top = INT64_MIN;
  for (const Dyadic* part : {&v.x, &v.y, &v.z}) {
    if (part->sign() != 0) top = std::max(top, part->log2() + 1);
  }
  if (top == INT64_MIN) return {};
  // Whole digits first, as those shifts are exact; at most 63 bits are left.
  const std::int64_t whole = floor_limbs(top);
  const auto bits = static_cast<int>(top - whole * kLimbBits);
  const auto scaled = [&](const Dyadic& part) {
    const Dyadic near = part.shifted_by_limbs(-whole);
    const double high = near.to_double(-bits);
    if (std::fabs(high) < kSmallestWithLow) return DoubleDouble{high, 0};
    return DoubleDouble{high, (near - Dyadic(std::ldexp(high, bits))).to_double(-bits)};
  };
  return {scaled(v.x), scaled(v.y), scaled(v.z)};
}

}  // namespace plannercheck
