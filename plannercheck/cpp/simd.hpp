// Lanes of doubles in the native width, by GCC/Clang vector extensions: no dependency, builds on x86-64 and aarch64.
#pragma once

#include <cstring>

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

}  // namespace plannercheck
