// Vectors of four doubles on every instruction set: where the layout of data is the same for all of them.
#pragma once

#include <cstring>

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "math/shuffle.hpp"

namespace plannercheck {

inline constexpr int kQuad = 4;

typedef double Quad __attribute__((vector_size(kQuad * 8)));
typedef long long QuadMask __attribute__((vector_size(kQuad * 8)));

inline Quad load_quad(const double* from) {
  Quad q;
  std::memcpy(&q, from, sizeof q);
  return q;
}

inline void store_quad(double* to, Quad q) { std::memcpy(to, &q, sizeof q); }

inline Quad absolute_quad(Quad q) {
  return reinterpret_cast<Quad>(reinterpret_cast<QuadMask>(q) & (QuadMask{} + 0x7fffffffffffffffLL));
}

// The largest number, in all places. Scalars in place of this branch, on what nothing can predict.
inline Quad spread_largest(Quad q) {
  const Quad halves = shuffled<2, 3, 0, 1>(q, q), two = q > halves ? q : halves;
  const Quad others = shuffled<1, 0, 3, 2>(two, two);
  return two > others ? two : others;
}

inline double largest(Quad q) { return spread_largest(q)[0]; }

// Bit k of the result: lane k of a comparison.
inline unsigned quad_bits(QuadMask mask) {
#if defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
  unsigned out = 0;
  for (int i = 0; i < kQuad; ++i) out |= mask[i] != 0 ? 1U << i : 0U;
  return out;
#endif
}

}  // namespace plannercheck
