// Sine and cosine of the angles of a block, in floats: within 2^-23 of the values for the given doubles.
//
// Idea: as in math/sincos.hpp, with less precision. The nearest multiple of pi/2 is subtracted in doubles, where one
// product is exact enough below kLargestAngle; the rest is rounded to floats, of which polynomials are evaluated, in
// fused steps where these save time.
#pragma once

#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"
#include "math/sincos.hpp"

namespace plannercheck {

// The largest error of either.
inline constexpr double kSinCosError = 0x1p-23;

struct FloatSinCos {
  StateFloats sin, cos;
};

namespace float_sincos_detail {

// The product of pi/2 with a multiple of it errs by up to 2^-34, as do so many times what pi/2 itself errs by.
inline constexpr double kLargestAngle = 1e6;
inline constexpr double kHalfPi = 0x1.921fb54442d18p+0;

// sin r = r + r z S(z), cos r = 1 - z/2 + z² C(z), z = r² in [0, (pi/4)²], interpolated at Chebyshev nodes and rounded:
// error of S 2.5e-8, of C 2.5e-9.
inline constexpr float kSin[3] = {-0x1.555552p-3F, 0x1.110c28p-7F, -0x1.9ac9b0p-13F};
inline constexpr float kCos[3] = {0x1.555554p-5F, -0x1.6c12d2p-10F, 0x1.9bd89cp-16F};

inline StateFloats polynomial(const float (&c)[3], StateFloats z) {
  const auto in_all = [](float number) { return filled<StateFloats>(number); };
  return multiply_add(z, multiply_add(z, in_all(c[2]), in_all(c[1])), in_all(c[0]));
}

// a b + c, rounded once on AVX-512; either will do for the reduction.
inline Lanes reduced_by(Lanes a, Lanes b, Lanes c) {
#if defined(__AVX512F__)
  return reinterpret_cast<Lanes>(
      _mm512_fmadd_pd(reinterpret_cast<__m512d>(a), reinterpret_cast<__m512d>(b), reinterpret_cast<__m512d>(c)));
#else
  return a * b + c;
#endif
}

inline StateFloats chosen(StateMask mask, StateFloats yes, StateFloats no) {
  return (StateFloats)((mask & (StateMask)yes) | (~mask & (StateMask)no));
}

}  // namespace float_sincos_detail

// Whether all angles of a group are small enough; false for NaN.
inline LaneMask are_reducible(Lanes angle) { return absolute(angle) <= broadcast(float_sincos_detail::kLargestAngle); }

// `angle`: of the groups of a block.
inline FloatSinCos float_sincos(const Lanes (&angle)[kBlockGroups]) {
  using namespace float_sincos_detail;
  using sincos_detail::kRoundToInteger, sincos_detail::kTwoOverPi;
  Lanes multiples[kBlockGroups], rests[kBlockGroups];
  for (std::size_t group = 0; group < kBlockGroups; ++group) {
    multiples[group] = reduced_by(angle[group], broadcast(kTwoOverPi), broadcast(kRoundToInteger));
    rests[group] = reduced_by(multiples[group] - kRoundToInteger, broadcast(-kHalfPi), angle[group]);
  }
  const StateMask quarter = joined_low_words<kBlockStates>(multiples);  // the multiples' last bits
  const StateFloats r = joined_floats<kBlockStates>(rests, 1);
  const StateFloats z = r * r;
  const StateFloats sin_r = multiply_add(r, z * polynomial(kSin, z), r);
  const StateFloats cos_r = multiply_add(z * z, polynomial(kCos, z), 1.0F - 0.5F * z);
  const StateMask swap = -(quarter & 1);
  const StateMask sin_sign = (quarter & 2) << 30, cos_sign = ((quarter + 1) & 2) << 30;
  return {(StateFloats)((StateMask)chosen(swap, cos_r, sin_r) ^ sin_sign),
          (StateFloats)((StateMask)chosen(swap, sin_r, cos_r) ^ cos_sign)};
}

}  // namespace plannercheck
