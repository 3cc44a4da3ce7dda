// Sine and cosine of kLanes angles at once, the same bits on every instruction set.
//
// In: angles in rad. Out: both values, within about 1 ulp. Idea: subtract the nearest multiple of pi/2, held in three
// parts so that the first two products are exact (Cody and Waite); evaluate two polynomials on [-pi/4, pi/4]; swap and
// negate by quadrant. Only elementwise additions and multiplications, none fused, so a lane's result depends on its
// angle alone. Angles beyond kLargestReduced are reduced lane by lane in integers (large_angle.hpp), to NaN if not
// finite.
#pragma once

#include "math/large_angle.hpp"
#include "math/simd.hpp"

namespace plannercheck {

template <class Numbers>
struct SinCosOf {
  Numbers sin, cos;
};
typedef SinCosOf<Lanes> SinCos;

namespace sincos_detail {

// The multiple of pi/2 must fit in 20 bits for its products with the 33-bit parts below to be exact.
inline constexpr double kLargestReduced = 1e6;
inline constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
inline constexpr double kHalfPiHigh = 0x1.921fb544p+0;       // first 33 bits of pi/2
inline constexpr double kHalfPiMiddle = 0x1.0b4611a6p-34;    // next 33 bits
inline constexpr double kHalfPiLow = 0x1.3198a2e037073p-69;  // the rest, rounded
inline constexpr double kRoundToInteger = 0x1.8p52;          // adding it leaves the nearest integer in the low bits

// Interpolants at Chebyshev nodes of z = r^2 in [0, (pi/4)^2], computed in 60 decimal digits:
// sin r = r + r z S(z), error of S 3.2e-17; cos r = 1 - z/2 + z^2 C(z), error of C 2.4e-18
// (with rounded coefficients, on a grid of 3,000 points).
inline constexpr double kSin[6] = {-0x1.5555555555555p-3, 0x1.1111111110bb2p-7,   -0x1.a01a019e83816p-13,
                                   0x1.71de379654304p-19, -0x1.ae600aca92c64p-26, 0x1.5e0b05bff20f2p-33};
inline constexpr double kCos[6] = {0x1.5555555555555p-5,   -0x1.6c16c16c16967p-10, 0x1.a01a019f4e9b4p-16,
                                   -0x1.27e4fa17bf139p-22, 0x1.1eeb68cd22f56p-29,  -0x1.907d8f29fe831p-37};

template <class Numbers>
using MaskOf = decltype(Numbers{} > Numbers{});

template <class Numbers>
Numbers polynomial(const double (&c)[6], Numbers z) {
  return c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * (c[4] + z * c[5]))));
}

template <class Numbers>
Numbers select(MaskOf<Numbers> mask, Numbers yes, Numbers no) {
  return (Numbers)((mask & (MaskOf<Numbers>)yes) | (~mask & (MaskOf<Numbers>)no));
}

// An angle less `quarter` times pi/2: r + tail. Only the two lowest bits of `quarter` count.
template <class Numbers>
struct Reduced {
  Numbers r, tail;
  MaskOf<Numbers> quarter;
};

template <class Numbers>
[[gnu::noinline, gnu::cold]] Reduced<Numbers> reduced_in_integers(const Numbers& angle, MaskOf<Numbers> where,
                                                                  Reduced<Numbers> out) {
  for (std::size_t lane = 0; lane < sizeof angle / sizeof angle[0]; ++lane) {
    if (!where[lane]) continue;
    const ReducedAngle each = reduced(angle[lane]);
    out.r[lane] = each.rest;
    out.tail[lane] = each.tail;
    out.quarter[lane] = each.quarter;
  }
  return out;
}

}  // namespace sincos_detail

template <class Numbers>
[[gnu::always_inline]] inline SinCosOf<Numbers> sincos(Numbers angle) {
  using namespace sincos_detail;
  typedef MaskOf<Numbers> Mask;
  const Numbers shifted = angle * kTwoOverPi + kRoundToInteger;
  Mask quarter = (Mask)shifted;  // its two lowest bits are the quadrant
  const Numbers n = shifted - kRoundToInteger;

  // r + tail = angle - n pi/2; the tail is what rounding takes from r.
  const Numbers first = angle - n * kHalfPiHigh;
  const Numbers middle = n * kHalfPiMiddle;
  const Numbers second = first - middle;
  const Numbers low = n * kHalfPiLow - ((first - second) - middle);
  Numbers r = second - low;
  Numbers tail = (second - r) - low;

  const Mask beyond = ~((angle <= Numbers{} + kLargestReduced) & (angle >= Numbers{} - kLargestReduced));
  if (bits(beyond) != 0) [[unlikely]] {
    const Reduced<Numbers> all = reduced_in_integers<Numbers>(angle, beyond, {r, tail, quarter});
    r = all.r, tail = all.tail, quarter = all.quarter;
  }

  const Numbers z = r * r;
  const Numbers half = 0.5 * z;
  const Numbers one_less = 1.0 - half;
  const Numbers sin_r = r + (r * z * polynomial(kSin, z) + tail * one_less);
  const Numbers cos_r = one_less + (((1.0 - one_less) - half) + (z * z * polynomial(kCos, z) - r * tail));

  const Mask swap = -(quarter & 1);
  const Mask sin_sign = (quarter & 2) << 62;
  const Mask cos_sign = ((quarter + 1) & 2) << 62;
  return {(Numbers)((Mask)select<Numbers>(swap, cos_r, sin_r) ^ sin_sign),
          (Numbers)((Mask)select<Numbers>(swap, sin_r, cos_r) ^ cos_sign)};
}

}  // namespace plannercheck
