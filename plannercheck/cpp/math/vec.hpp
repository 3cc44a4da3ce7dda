// Points, directions and poses in doubles.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace plannercheck {

// Indices are kept in 32 bits.
inline std::size_t at(std::int32_t index) { return static_cast<std::size_t>(index); }

// 0 … count − 1
inline std::vector<std::int32_t> indices_below(std::size_t count) {
  std::vector<std::int32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

struct Vec3 {
  double x = 0, y = 0, z = 0;

  double operator[](std::integral auto axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline bool operator==(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double norm(Vec3 a) { return std::sqrt(dot(a, a)); }
// std::fmax is a function call, as it has to handle NaN.
inline double larger(double a, double b) { return a > b ? a : b; }
inline double smaller(double a, double b) { return a < b ? a : b; }
inline Vec3 larger(Vec3 a, Vec3 b) { return {larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)}; }
inline Vec3 smaller(Vec3 a, Vec3 b) { return {smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z)}; }
inline Vec3 absolute(Vec3 a) { return {std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)}; }
inline double norm_max(Vec3 a) { return larger(std::fabs(a.x), larger(std::fabs(a.y), std::fabs(a.z))); }
inline double norm_1(Vec3 a) { return std::fabs(a.x) + std::fabs(a.y) + std::fabs(a.z); }

// Only greater lengths are trusted, and squares above its square: smaller ones lose bits to underflow.
inline constexpr double kTrustedLength = 1e-150;

// Bounds the error of products and sums of a few denormal terms, whatever their size: each errs by half of 2^-1074.
inline constexpr double kDenormalError = 0x1p-1060;

// A nonzero vector in units of its largest entry: its squares neither overflow nor underflow.
inline Vec3 in_units_of_largest(Vec3 v) {
  const double largest = norm_max(v);
  return {v.x / largest, v.y / largest, v.z / largest};
}

inline Vec3 unit(Vec3 v) {
  const Vec3 scaled = in_units_of_largest(v);
  return (1 / norm(scaled)) * scaled;
}

// |v| up to 4u and a denormal, even where squares overflow or underflow; infinite if an entry is.
inline double norm_at_any_scale(Vec3 v) {
  const double largest = norm_max(v);
  if ((largest > kTrustedLength && largest < 1 / kTrustedLength) || largest == 0) return norm(v);
  if (std::isinf(largest)) return largest;
  return largest * norm(in_units_of_largest(v));
}

// An upper bound of |v| that exceeds it by at most 2^-47 of itself and a denormal.
inline double norm_above(Vec3 v) {
  constexpr double kRoundUp = 1 + 0x1p-48;  // covers the rounding of a norm
  const double length = norm_at_any_scale(v) * kRoundUp;
  return length > 0 && length < kTrustedLength ? length + kDenormalError : length;
}

// An affine map x -> M x + t; `m` holds the rows of the 3x4 matrix [M | t].
struct Pose {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  Vec3 column(std::size_t j) const { return {m[j], m[j + 4], m[j + 8]}; }
  Vec3 translation() const { return column(3); }

  // M v
  Vec3 rotate(Vec3 v) const {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
  }

  // Mᵀ v
  Vec3 rotate_back(Vec3 v) const {
    return {m[0] * v.x + m[4] * v.y + m[8] * v.z, m[1] * v.x + m[5] * v.y + m[9] * v.z,
            m[2] * v.x + m[6] * v.y + m[10] * v.z};
  }

  Vec3 apply(Vec3 v) const { return rotate(v) + translation(); }
};

// ‖MᵀM − 1‖ in the Frobenius norm, as computed in doubles.
inline double rigidity_defect(const Pose& pose) {
  const auto& m = pose.m;
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const double entry = m[a] * m[b] + m[a + 4] * m[b + 4] + m[a + 8] * m[b + 8] - (i == j ? 1.0 : 0.0);
      sum += (i == j ? 1.0 : 2.0) * entry * entry;
    }
  }
  return std::sqrt(sum);
}

}  // namespace plannercheck
