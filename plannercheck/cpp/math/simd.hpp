// Lanes of doubles in the native width, and eight floats, by GCC/Clang vector extensions: no dependency, builds on
// x86-64 and aarch64.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "math/shuffle.hpp"

namespace plannercheck {

// PLANNERCHECK_EIGHT_LANES: AVX-512's number of lanes on a machine without it, to test that code.
#if defined(__AVX512F__) || defined(PLANNERCHECK_EIGHT_LANES)
inline constexpr int kLanes = 8;
#elif defined(__AVX__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

typedef double Lanes __attribute__((vector_size(kLanes * 8)));
typedef long long LaneMask __attribute__((vector_size(kLanes * 8)));

// Eight floats: one register of AVX2, two of SSE; on AVX-512 half of one, for the same layout everywhere.
inline constexpr int kFloats = 8;
typedef float Floats __attribute__((vector_size(kFloats * 4)));
typedef int FloatMask __attribute__((vector_size(kFloats * 4)));

inline Floats load_floats(const float* from) {
  Floats floats;
  std::memcpy(&floats, from, sizeof floats);
  return floats;
}

inline void store_floats(float* to, Floats floats) { std::memcpy(to, &floats, sizeof floats); }

// As many floats as there are lanes, as doubles.
inline Lanes load_widened(const float* from) {
  typedef float Narrow __attribute__((vector_size(kLanes * 4)));
  Narrow narrow;
  std::memcpy(&narrow, from, sizeof narrow);
  return __builtin_convertvector(narrow, Lanes);
}

inline Lanes load_lanes(const double* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

inline void store_lanes(double* to, Lanes lanes) { std::memcpy(to, &lanes, sizeof lanes); }

// Numbers in Lanes as `count` floats, each rounded to the nearest; group g of the lanes is at from[g * stride]. The
// register is written at once: a wide load after narrower stores would wait for them.
template <int count = kFloats>
inline auto joined_floats(const Lanes* from, std::size_t stride) {
  if constexpr (count == kLanes) {
    typedef float Narrow __attribute__((vector_size(kLanes * 4)));
    return __builtin_convertvector(*from, Narrow);
  } else {
    const auto low = joined_floats<count / 2>(from, stride);
    const auto high = joined_floats<count / 2>(from + count / 2 / kLanes * stride, stride);
    return [&]<int... k>(std::integer_sequence<int, k...>) {
      return shuffled<k...>(low, high);
    }(std::make_integer_sequence<int, count>{});
  }
}

// The low 32 bits of each of `count` numbers in Lanes, one group after the other.
template <int count>
inline auto joined_low_words(const Lanes* from) {
  typedef int Words __attribute__((vector_size(sizeof(Lanes))));
  constexpr auto places = std::make_integer_sequence<int, count>{};
  if constexpr (count == 2 * kLanes) {
    return [&]<int... k>(std::integer_sequence<int, k...>) {
      return shuffled<2 * k...>(reinterpret_cast<Words>(from[0]), reinterpret_cast<Words>(from[1]));
    }(places);
  } else {
    const auto low = joined_low_words<count / 2>(from), high = joined_low_words<count / 2>(from + count / 2 / kLanes);
    return [&]<int... k>(std::integer_sequence<int, k...>) { return shuffled<k...>(low, high); }(places);
  }
}

// Vectors of any number of floats.
template <class Vector>
concept FloatVector = std::is_same_v<std::remove_cvref_t<decltype(std::declval<Vector&>()[0])>, float>;

template <FloatVector Vector>
inline Vector absolute(Vector a) {
  typedef int Mask __attribute__((vector_size(sizeof(Vector))));
  return reinterpret_cast<Vector>(reinterpret_cast<Mask>(a) & (Mask{} + 0x7fffffff));
}

// The lanes after the first one, then the first one of those that follow.
inline Lanes next_lanes(Lanes lanes, Lanes following) {
  return [&]<int... k>(std::integer_sequence<int, k...>) {
    return shuffled<k + 1 ...>(lanes, following);
  }(std::make_integer_sequence<int, kLanes>{});
}

// A number in every lane. Taking 0 from it costs nothing; adding 0, as below, takes an addition, which makes −0 to 0.
template <class Vector, class Number>
inline Vector filled(Number value) {
  return value - Vector{};
}

// a b + c and a b − c of bounds in floats: rounded once on AVX-512, whose units for products are those for sums; else
// twice. Errors of the former are within those of the latter.
template <class Vector>
inline Vector multiply_add(Vector a, Vector b, Vector c) {
#if defined(__AVX512F__)
  if constexpr (FloatVector<Vector> && sizeof(Vector) == 64) {
    return reinterpret_cast<Vector>(
        _mm512_fmadd_ps(reinterpret_cast<__m512>(a), reinterpret_cast<__m512>(b), reinterpret_cast<__m512>(c)));
  }
  if constexpr (FloatVector<Vector> && sizeof(Vector) == 32) {
    return reinterpret_cast<Vector>(
        _mm256_fmadd_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b), reinterpret_cast<__m256>(c)));
  }
#endif
  return a * b + c;
}
template <class Vector>
inline Vector multiply_subtract(Vector a, Vector b, Vector c) {
  return multiply_add(a, b, -c);
}

// x a + y b + z c, from the left, in such steps.
template <class Vector>
inline Vector dot_of(Vector x, Vector y, Vector z, Vector a, Vector b, Vector c) {
  return multiply_add(z, c, multiply_add(y, b, x * a));
}

inline Lanes broadcast(double value) { return Lanes{} + value; }

inline Lanes absolute(Lanes a) {
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(a) & (LaneMask{} + 0x7fffffffffffffffLL));
}

inline double absolute(double a) { return std::fabs(a); }

inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }
template <FloatVector Vector>
inline Vector larger(Vector a, Vector b) {
  return a > b ? a : b;
}
template <FloatVector Vector>
inline Vector smaller(Vector a, Vector b) {
  return a < b ? a : b;
}

template <FloatVector Vector, FloatVector Half>
inline Vector repeated(Half half) {
  return shuffled<0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7>(half, half);
}

// The smallest lane, in every lane.
template <FloatVector Vector>
inline Vector smallest_everywhere(Vector a) {
  if constexpr (sizeof(Vector) == sizeof(Floats)) {
    a = smaller(a, shuffled<4, 5, 6, 7, 0, 1, 2, 3>(a, a));
    a = smaller(a, shuffled<2, 3, 0, 1, 6, 7, 4, 5>(a, a));
    return smaller(a, shuffled<1, 0, 3, 2, 5, 4, 7, 6>(a, a));
  } else {
    return repeated<Vector>(smallest_everywhere(
        smaller(shuffled<0, 1, 2, 3, 4, 5, 6, 7>(a, a), shuffled<8, 9, 10, 11, 12, 13, 14, 15>(a, a))));
  }
}

// The floats at these places, 0 to 7.
inline Floats picked(Floats from, FloatMask places) {
#if defined(__AVX2__)
  return reinterpret_cast<Floats>(
      _mm256_permutevar8x32_ps(reinterpret_cast<__m256>(from), reinterpret_cast<__m256i>(places)));
#else
  Floats out;
  for (int k = 0; k < kFloats; ++k) out[k] = from[places[k]];
  return out;
#endif
}

typedef int LaneIndices __attribute__((vector_size(kLanes * 4)));

// Bytes at indices; up to so many bytes after each are read as well.
inline constexpr std::size_t kGatheredBeyond = 3;
inline LaneIndices gathered_bytes(const unsigned char* from, LaneIndices index) {
#if defined(__AVX512F__)
  const auto fours = reinterpret_cast<LaneIndices>(
      _mm256_i32gather_epi32(reinterpret_cast<const int*>(from), reinterpret_cast<__m256i>(index), 1));
  return fours & 0xff;
#elif defined(__AVX2__) && !defined(PLANNERCHECK_EIGHT_LANES)
  const auto fours = reinterpret_cast<LaneIndices>(
      _mm_i32gather_epi32(reinterpret_cast<const int*>(from), reinterpret_cast<__m128i>(index), 1));
  return fours & 0xff;
#else
  LaneIndices bytes;
  for (int k = 0; k < kLanes; ++k) bytes[k] = from[index[k]];
  return bytes;
#endif
}

// Gathers 16-bit numbers by their indices, for any count of lanes; also reads the number after each.
template <class Indices>
inline Indices gathered_shorts(const unsigned short* from, Indices index) {
#if defined(__AVX512F__)
  if constexpr (sizeof(Indices) == 64) {
    const auto at = reinterpret_cast<__m512i>(index);
    return reinterpret_cast<Indices>(_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff, at, from, 2)) & 0xffff;
  }
#endif
#if defined(__AVX2__)
  if constexpr (sizeof(Indices) == 32) {
    const auto* const words = reinterpret_cast<const int*>(from);
    return reinterpret_cast<Indices>(_mm256_i32gather_epi32(words, reinterpret_cast<__m256i>(index), 2)) & 0xffff;
  }
#endif
  Indices shorts;
  for (std::size_t k = 0; k < sizeof index / sizeof index[0]; ++k) shorts[k] = from[index[k]];
  return shorts;
}

// Bit k of the result: lane k of a comparison.
template <class Mask>
inline unsigned bits(Mask mask) {
  [[maybe_unused]] constexpr bool are_doubles = sizeof mask[0] == sizeof(double);
#if defined(__AVX512DQ__)
  if constexpr (sizeof mask == 64 && are_doubles) return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
  if constexpr (sizeof mask == 64 && !are_doubles) return _mm512_movepi32_mask(reinterpret_cast<__m512i>(mask));
#endif
#if defined(__AVX__)
  if constexpr (sizeof mask == 32 && are_doubles)
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
  if constexpr (sizeof mask == 32 && !are_doubles)
    return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#endif
  unsigned out = 0;
  for (std::size_t k = 0; k < sizeof mask / sizeof mask[0]; ++k) out |= mask[k] != 0 ? 1U << k : 0U;
  return out;
}

#if defined(__AVX512VL__) && defined(__AVX512DQ__)
// AVX-512 compares into bits at once, of which GCC makes a mask in lanes before it can be asked for its bits.
template <int comparison, class Vector>
inline unsigned compared_bits(Vector a, Vector b) {
  if constexpr (!FloatVector<Vector>) {
    return _mm512_cmp_pd_mask(reinterpret_cast<__m512d>(a), reinterpret_cast<__m512d>(b), comparison);
  } else if constexpr (sizeof(Vector) == 64) {
    return _mm512_cmp_ps_mask(reinterpret_cast<__m512>(a), reinterpret_cast<__m512>(b), comparison);
  } else {
    return _mm256_cmp_ps_mask(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b), comparison);
  }
}
#endif

// Bit k of the result: whether a > b in lane k.
template <class Vector>
inline unsigned bits_above(Vector a, Vector b) {
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
  return compared_bits<_CMP_GT_OS>(a, b);
#else
  return bits(a > b);
#endif
}

// The bits of several comparisons: whether any of them holds in lane k.
template <FloatVector Vector>
class BitsOfAny {
 public:
  void add_above(Vector a, Vector b) {
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
    bits_ |= bits_above(a, b);
#else
    mask_ |= a > b;
#endif
  }

  unsigned bits() const {
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
    return bits_;
#else
    return plannercheck::bits(mask_);
#endif
  }

 private:
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
  unsigned bits_ = 0;
#else
  decltype(Vector{} > Vector{}) mask_{};
#endif
};

// Bit k of the result: whether a <= b in lane k.
template <class Vector>
inline unsigned bits_at_most(Vector a, Vector b) {
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
  return compared_bits<_CMP_LE_OS>(a, b);
#else
  return bits(a <= b);
#endif
}

inline float largest(Floats floats) {
#if defined(__AVX__)
  const __m256 all = reinterpret_cast<__m256>(floats);
  __m128 four = _mm_max_ps(_mm256_castps256_ps128(all), _mm256_extractf128_ps(all, 1));
  four = _mm_max_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_max_ss(four, _mm_movehdup_ps(four)));
#else
  float most = floats[0];
  for (int i = 1; i < kFloats; ++i) most = floats[i] > most ? floats[i] : most;
  return most;
#endif
}

}  // namespace plannercheck
