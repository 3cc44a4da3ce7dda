// Vectors of four doubles on every instruction set, for data with the same layout on all of them.
#pragma once

#include <cstring>

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "math/shuffle.hpp"

namespace plannercheck {

inline constexpr int kDouble4Lanes = 4;

typedef double Double4 __attribute__((vector_size(kDouble4Lanes * 8)));
typedef long long Double4Mask __attribute__((vector_size(kDouble4Lanes * 8)));

inline Double4 load_double4(const double* from) {
  Double4 q;
  std::memcpy(&q, from, sizeof q);
  return q;
}

inline void store_double4(double* to, Double4 q) { std::memcpy(to, &q, sizeof q); }

inline Double4 absolute_double4(Double4 q) {
  return reinterpret_cast<Double4>(reinterpret_cast<Double4Mask>(q) & (Double4Mask{} + 0x7fffffffffffffffLL));
}

// The largest number, in all places. Scalars in place of this branch, on what nothing can predict.
inline Double4 spread_largest(Double4 q) {
  const Double4 halves = shuffled<2, 3, 0, 1>(q, q), two = q > halves ? q : halves;
  const Double4 others = shuffled<1, 0, 3, 2>(two, two);
  return two > others ? two : others;
}

inline double largest(Double4 q) { return spread_largest(q)[0]; }

// Bit k of the result: lane k of a comparison.
inline unsigned double4_bits(Double4Mask mask) {
#if defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
  unsigned out = 0;
  for (int i = 0; i < kDouble4Lanes; ++i) out |= mask[i] != 0 ? 1U << i : 0U;
  return out;
#endif
}

}  // namespace plannercheck
