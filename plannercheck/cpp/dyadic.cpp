#include "dyadic.hpp"

#include <algorithm>
#include <cmath>

namespace plannercheck {
namespace {

using Limbs = std::vector<std::uint32_t>;
constexpr int kLimbBits = 32;

int compare_magnitudes(const Limbs& a, const Limbs& b) {
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  for (std::size_t i = a.size(); i-- > 0;) {
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  }
  return 0;
}

void drop_leading_zeros(Limbs& limbs) {
  while (!limbs.empty() && limbs.back() == 0) limbs.pop_back();
}

Limbs shift_left(const Limbs& limbs, std::int64_t bits) {
  const auto whole = static_cast<std::size_t>(bits / kLimbBits);
  const int part = static_cast<int>(bits % kLimbBits);
  Limbs out(whole + limbs.size() + 1, 0);
  for (std::size_t i = 0; i < limbs.size(); ++i) {
    const std::uint64_t wide = static_cast<std::uint64_t>(limbs[i]) << part;
    out[whole + i] |= static_cast<std::uint32_t>(wide);
    out[whole + i + 1] |= static_cast<std::uint32_t>(wide >> kLimbBits);
  }
  drop_leading_zeros(out);
  return out;
}

Limbs add_magnitudes(const Limbs& a, const Limbs& b) {
  const Limbs& longer = a.size() >= b.size() ? a : b;
  const Limbs& shorter = a.size() >= b.size() ? b : a;
  Limbs out(longer.size() + 1);
  std::uint64_t carry = 0;
  for (std::size_t i = 0; i < longer.size(); ++i) {
    carry += static_cast<std::uint64_t>(longer[i]) + (i < shorter.size() ? shorter[i] : 0U);
    out[i] = static_cast<std::uint32_t>(carry);
    carry >>= kLimbBits;
  }
  out.back() = static_cast<std::uint32_t>(carry);
  drop_leading_zeros(out);
  return out;
}

// |a| >= |b|
Limbs subtract_magnitudes(const Limbs& a, const Limbs& b) {
  Limbs out(a.size());
  std::int64_t borrow = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::int64_t digit = static_cast<std::int64_t>(a[i]) - (i < b.size() ? b[i] : 0U) - borrow;
    borrow = digit < 0 ? 1 : 0;
    if (borrow) digit += std::int64_t{1} << kLimbBits;
    out[i] = static_cast<std::uint32_t>(digit);
  }
  drop_leading_zeros(out);
  return out;
}

}  // namespace

Dyadic::Dyadic(double value) {
  if (value == 0) return;
  int exponent = 0;
  const double mantissa = std::frexp(std::fabs(value), &exponent);
  auto integer = static_cast<std::uint64_t>(std::ldexp(mantissa, 53));
  exponent_ = exponent - 53;
  sign_ = value > 0 ? 1 : -1;
  const int zeros = __builtin_ctzll(integer);
  integer >>= zeros;
  exponent_ += zeros;
  limbs_ = {static_cast<std::uint32_t>(integer), static_cast<std::uint32_t>(integer >> kLimbBits)};
  drop_leading_zeros(limbs_);
}

void Dyadic::trim() {
  if (limbs_.empty()) {
    sign_ = 0;
    exponent_ = 0;
    return;
  }
  std::size_t zeros = 0;
  while (limbs_[zeros] == 0) ++zeros;
  if (zeros > 0) {
    limbs_.erase(limbs_.begin(), limbs_.begin() + static_cast<std::ptrdiff_t>(zeros));
    exponent_ += static_cast<std::int64_t>(zeros) * kLimbBits;
  }
}

std::int64_t Dyadic::log2() const {
  const int top = kLimbBits - 1 - __builtin_clz(limbs_.back());
  return exponent_ + static_cast<std::int64_t>(limbs_.size() - 1) * kLimbBits + top;
}

double Dyadic::to_double() const {
  if (sign_ == 0) return 0;
  // The three leading limbs hold at least 65 bits: more than a double.
  double value = 0;
  const std::size_t count = std::min<std::size_t>(limbs_.size(), 3);
  for (std::size_t i = 0; i < count; ++i) value = value * 4294967296.0 + limbs_[limbs_.size() - 1 - i];
  const std::int64_t scale = exponent_ + static_cast<std::int64_t>(limbs_.size() - count) * kLimbBits;
  return sign_ * std::ldexp(value, static_cast<int>(std::clamp<std::int64_t>(scale, -4000, 4000)));
}

std::string Dyadic::hexadecimal() const {
  if (sign_ == 0) return "0";
  std::string digits;
  for (const std::uint32_t limb : limbs_) {
    for (int shift = 0; shift < kLimbBits; shift += 4) digits.push_back("0123456789abcdef"[limb >> shift & 15U]);
  }
  while (digits.back() == '0') digits.pop_back();
  if (sign_ < 0) digits.push_back('-');
  return {digits.rbegin(), digits.rend()};
}

Dyadic Dyadic::shifted(std::int64_t bits) const {
  Dyadic out = *this;
  if (out.sign_ != 0) out.exponent_ += bits;
  return out;
}

Dyadic Dyadic::operator-() const {
  Dyadic out = *this;
  out.sign_ = -out.sign_;
  return out;
}

Dyadic operator+(const Dyadic& a, const Dyadic& b) {
  if (a.sign_ == 0) return b;
  if (b.sign_ == 0) return a;
  const Dyadic& high = a.exponent_ >= b.exponent_ ? a : b;
  const Dyadic& low = a.exponent_ >= b.exponent_ ? b : a;
  const Limbs aligned = shift_left(high.limbs_, high.exponent_ - low.exponent_);
  Dyadic out;
  out.exponent_ = low.exponent_;
  if (high.sign_ == low.sign_) {
    out.sign_ = high.sign_;
    out.limbs_ = add_magnitudes(aligned, low.limbs_);
  } else {
    const int order = compare_magnitudes(aligned, low.limbs_);
    if (order == 0) return {};
    out.sign_ = order > 0 ? high.sign_ : low.sign_;
    out.limbs_ = order > 0 ? subtract_magnitudes(aligned, low.limbs_) : subtract_magnitudes(low.limbs_, aligned);
  }
  out.trim();
  return out;
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  if (a.sign_ == 0 || b.sign_ == 0) return {};
  Dyadic out;
  out.sign_ = a.sign_ * b.sign_;
  out.exponent_ = a.exponent_ + b.exponent_;
  out.limbs_.assign(a.limbs_.size() + b.limbs_.size(), 0);
  for (std::size_t i = 0; i < a.limbs_.size(); ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < b.limbs_.size(); ++j) {
      carry += out.limbs_[i + j] + static_cast<std::uint64_t>(a.limbs_[i]) * b.limbs_[j];
      out.limbs_[i + j] = static_cast<std::uint32_t>(carry);
      carry >>= kLimbBits;
    }
    out.limbs_[i + b.limbs_.size()] = static_cast<std::uint32_t>(carry);
  }
  drop_leading_zeros(out.limbs_);
  out.trim();
  return out;
}

DyadicVec3 operator+(const DyadicVec3& a, const DyadicVec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
DyadicVec3 operator-(const DyadicVec3& a, const DyadicVec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
DyadicVec3 operator*(const Dyadic& s, const DyadicVec3& a) { return {s * a.x, s * a.y, s * a.z}; }
Dyadic dot(const DyadicVec3& a, const DyadicVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
DyadicVec3 cross(const DyadicVec3& a, const DyadicVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

DyadicVec3 apply_exactly(const Pose& pose, Vec3 v) {
  const auto& m = pose.m;
  const DyadicVec3 p(v);
  const auto row = [&](std::size_t i) {
    return Dyadic(m[i]) * p.x + Dyadic(m[i + 1]) * p.y + Dyadic(m[i + 2]) * p.z + Dyadic(m[i + 3]);
  };
  return {row(0), row(4), row(8)};
}

Vec3 direction_of(const DyadicVec3& v) {
  std::int64_t top = INT64_MIN;
  for (const Dyadic* part : {&v.x, &v.y, &v.z}) {
    if (part->sign() != 0) top = std::max(top, part->log2());
  }
  if (top == INT64_MIN) return {};
  return {v.x.shifted(-top - 1).to_double(), v.y.shifted(-top - 1).to_double(), v.z.shifted(-top - 1).to_double()};
}

}  // namespace plannercheck
