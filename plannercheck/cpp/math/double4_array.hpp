// Four or eight numbers, held in quads, and operations on all of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>

#include "math/double4.hpp"

namespace plannercheck {

template <int kVectors>
struct Double4Array {
  std::array<Double4, kVectors> vectors;

  static Double4Array all(double value) {
    Double4Array out;
    for (Double4& q : out.vectors) q = Double4{} + value;
    return out;
  }
  static Double4Array load(const double* from) {
    Double4Array out;
    for (int i = 0; i < kVectors; ++i) out[i] = load_double4(from + i * kDouble4Lanes);
    return out;
  }
  void store(double* to) const {
    for (int i = 0; i < kVectors; ++i) store_double4(to + i * kDouble4Lanes, (*this)[i]);
  }
  Double4& operator[](int i) { return vectors[static_cast<std::size_t>(i)]; }
  Double4 operator[](int i) const { return vectors[static_cast<std::size_t>(i)]; }

  template <class Operation>
  static Double4Array of(Operation operation) {
    Double4Array out;
    for (int i = 0; i < kVectors; ++i) out[i] = operation(i);
    return out;
  }
  friend Double4Array operator+(const Double4Array& a, const Double4Array& b) {
    return of([&](int i) { return a[i] + b[i]; });
  }
  friend Double4Array operator-(const Double4Array& a, const Double4Array& b) {
    return of([&](int i) { return a[i] - b[i]; });
  }
  friend Double4Array operator*(double a, const Double4Array& b) {
    return of([&](int i) { return a * b[i]; });
  }
  friend Double4Array operator-(const Double4Array& a) {
    return of([&](int i) { return -a[i]; });
  }
};

inline Double4Mask load_mask(const long long* from) {
  Double4Mask out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

// A mask of one place: all bits set there.
template <int kVectors>
struct SingleLaneMask {
  std::array<Double4Mask, kVectors> mask;

  explicit SingleLaneMask(int k) {
    // Sixteen numbers of which one is set; reading from the right offset puts it at the place.
    static constexpr std::array<long long, 16> kOne{0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0};
    for (std::size_t i = 0; i < kVectors; ++i) mask[i] = load_mask(kOne.data() + 8 - k + i * kDouble4Lanes);
  }
  // The numbers, with the one at the place replaced.
  Double4Array<kVectors> with(const Double4Array<kVectors>& e, double value) const {
    return Double4Array<kVectors>::of(
        [&](int i) { return mask[static_cast<std::size_t>(i)] ? Double4{} + value : e[i]; });
  }
};

template <int kVectors>
double most(const Double4Array<kVectors>& e) {
  Double4 four = e[0];
  if constexpr (kVectors > 1) four = four > e[1] ? four : e[1];
  return largest(four);
}

template <int kVectors>
double least(const Double4Array<kVectors>& e) {
  return -most(-e);
}

// Bits of the places whose numbers exceed a value.
template <int kVectors>
unsigned above(const Double4Array<kVectors>& e, double value) {
  unsigned out = 0;
  for (int i = 0; i < kVectors; ++i) out |= double4_bits(e[i] > Double4{} + value) << (i * kDouble4Lanes);
  return out;
}

// Bits of the places whose numbers equal a value.
template <int kVectors>
unsigned equals(const Double4Array<kVectors>& e, double value) {
  unsigned out = 0;
  for (int i = 0; i < kVectors; ++i) out |= double4_bits(e[i] == Double4{} + value) << (i * kDouble4Lanes);
  return out;
}

// The first place that holds a value; their number if none does.
template <int kVectors>
int place(const Double4Array<kVectors>& e, double value) {
  return __builtin_ctz(equals(e, value) | 1U << (kVectors * kDouble4Lanes));
}

template <int kVectors>
double sum(const Double4Array<kVectors>& e) {
  Double4 four = e[0];
  if constexpr (kVectors > 1) four += e[1];
  return (four[0] + four[1]) + (four[2] + four[3]);
}

// The first numbers, zeros in place of the others.
template <int kVectors>
Double4Array<kVectors> first_of(const Double4Array<kVectors>& e, int count) {
  static constexpr std::array<long long, 16> kFirst{-1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0};
  return Double4Array<kVectors>::of([&](int i) {
    return reinterpret_cast<Double4>(reinterpret_cast<Double4Mask>(e[i]) &
                                     load_mask(kFirst.data() + 8 - count + i * kDouble4Lanes));
  });
}

}  // namespace plannercheck
