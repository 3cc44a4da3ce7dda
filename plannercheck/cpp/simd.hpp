// Lanes of doubles in the native width, by GCC/Clang vector extensions: no dependency, builds on x86-64 and aarch64.
#pragma once

#include <cstring>

#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace plannercheck {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

typedef double Lanes __attribute__((vector_size(kLanes * 8)));
typedef long long LaneMask __attribute__((vector_size(kLanes * 8)));

inline Lanes load_lanes(const double* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

inline void store_lanes(double* to, Lanes lanes) { std::memcpy(to, &lanes, sizeof lanes); }

inline Lanes broadcast(double value) { return Lanes{} + value; }

inline Lanes absolute(Lanes a) {
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(a) & (LaneMask{} + 0x7fffffffffffffffLL));
}

inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }

// Bit k of the result: lane k of a comparison.
inline unsigned bits(LaneMask mask) {
#if defined(__AVX512DQ__)
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
#elif defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
  unsigned out = 0;
  for (int i = 0; i < kLanes; ++i) out |= mask[i] != 0 ? 1U << i : 0U;
  return out;
#endif
}

}  // namespace plannercheck
