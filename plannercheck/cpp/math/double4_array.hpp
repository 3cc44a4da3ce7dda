// Four or eight numbers, by quads, and what is asked of them as a whole.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>

#include "math/double4.hpp"

namespace plannercheck {

template <int kQuads>
struct Few {
  std::array<Quad, kQuads> quad;

  static Few all(double value) {
    Few out;
    for (Quad& q : out.quad) q = Quad{} + value;
    return out;
  }
  static Few load(const double* from) {
    Few out;
    for (int i = 0; i < kQuads; ++i) out[i] = load_quad(from + i * kQuad);
    return out;
  }
  void store(double* to) const {
    for (int i = 0; i < kQuads; ++i) store_quad(to + i * kQuad, (*this)[i]);
  }
  Quad& operator[](int i) { return quad[static_cast<std::size_t>(i)]; }
  Quad operator[](int i) const { return quad[static_cast<std::size_t>(i)]; }

  template <class Operation>
  static Few of(Operation operation) {
    Few out;
    for (int i = 0; i < kQuads; ++i) out[i] = operation(i);
    return out;
  }
  friend Few operator+(const Few& a, const Few& b) {
    return of([&](int i) { return a[i] + b[i]; });
  }
  friend Few operator-(const Few& a, const Few& b) {
    return of([&](int i) { return a[i] - b[i]; });
  }
  friend Few operator*(double a, const Few& b) {
    return of([&](int i) { return a * b[i]; });
  }
  friend Few operator-(const Few& a) {
    return of([&](int i) { return -a[i]; });
  }
};

inline QuadMask load_mask(const long long* from) {
  QuadMask out;
  std::memcpy(&out, from, sizeof out);
  return out;
}

// All bits of one of the places.
template <int kQuads>
struct Place {
  std::array<QuadMask, kQuads> mask;

  explicit Place(int k) {
    // Sixteen numbers of which one is set, read from where it comes to the place.
    static constexpr std::array<long long, 16> kOne{0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0};
    for (std::size_t i = 0; i < kQuads; ++i) mask[i] = load_mask(kOne.data() + 8 - k + i * kQuad);
  }
  // The numbers, with another one at the place.
  Few<kQuads> with(const Few<kQuads>& e, double value) const {
    return Few<kQuads>::of([&](int i) { return mask[static_cast<std::size_t>(i)] ? Quad{} + value : e[i]; });
  }
};

template <int kQuads>
double most(const Few<kQuads>& e) {
  Quad four = e[0];
  if constexpr (kQuads > 1) four = four > e[1] ? four : e[1];
  return largest(four);
}

template <int kQuads>
double least(const Few<kQuads>& e) {
  return -most(-e);
}

// Where the numbers are above a value, as bits.
template <int kQuads>
unsigned above(const Few<kQuads>& e, double value) {
  unsigned out = 0;
  for (int i = 0; i < kQuads; ++i) out |= quad_bits(e[i] > Quad{} + value) << (i * kQuad);
  return out;
}

// Where the numbers equal a value, as bits.
template <int kQuads>
unsigned equals(const Few<kQuads>& e, double value) {
  unsigned out = 0;
  for (int i = 0; i < kQuads; ++i) out |= quad_bits(e[i] == Quad{} + value) << (i * kQuad);
  return out;
}

// The first place of a value that is there.
template <int kQuads>
int place(const Few<kQuads>& e, double value) {
  return __builtin_ctz(equals(e, value) | 1U << (kQuads * kQuad));
}

template <int kQuads>
double sum(const Few<kQuads>& e) {
  Quad four = e[0];
  if constexpr (kQuads > 1) four += e[1];
  return (four[0] + four[1]) + (four[2] + four[3]);
}

// The first of the numbers; zeros for the others.
template <int kQuads>
Few<kQuads> first_of(const Few<kQuads>& e, int count) {
  static constexpr std::array<long long, 16> kFirst{-1, -1, -1, -1, -1, -1, -1, -1, 0, 0, 0, 0, 0, 0, 0, 0};
  return Few<kQuads>::of([&](int i) {
    return reinterpret_cast<Quad>(reinterpret_cast<QuadMask>(e[i]) & load_mask(kFirst.data() + 8 - count + i * kQuad));
  });
}

}  // namespace plannercheck
