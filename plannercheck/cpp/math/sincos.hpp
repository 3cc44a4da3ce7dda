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

struct SinCos {
  Lanes sin, cos;
};

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

inline Lanes polynomial(const double (&c)[6], Lanes z) {
  return c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * (c[4] + z * c[5]))));
}

inline Lanes select(LaneMask mask, Lanes yes, Lanes no) {
  return (Lanes)((mask & (LaneMask)yes) | (~mask & (LaneMask)no));
}

// An angle less `quarter` times pi/2: r + tail. Only the two lowest bits of `quarter` count.
struct Reduced {
  Lanes r, tail;
  LaneMask quarter;
};

[[gnu::noinline, gnu::cold]] inline Reduced reduced_in_integers(const Lanes& angle, LaneMask where, Reduced out) {
  for (int lane = 0; lane < kLanes; ++lane) {
    if (!where[lane]) continue;
    const ReducedAngle each = reduced(angle[lane]);
    out.r[lane] = each.rest;
    out.tail[lane] = each.tail;
    out.quarter[lane] = each.quarter;
  }
  return out;
}

}  // namespace sincos_detail

inline SinCos sincos(Lanes angle) {
  using namespace sincos_detail;
  const Lanes shifted = angle * kTwoOverPi + kRoundToInteger;
  LaneMask quarter = (LaneMask)shifted;  // its two lowest bits are the quadrant
  const Lanes n = shifted - kRoundToInteger;

  // r + tail = angle - n pi/2; the tail is what rounding takes from r.
  const Lanes first = angle - n * kHalfPiHigh;
  const Lanes middle = n * kHalfPiMiddle;
  const Lanes second = first - middle;
  const Lanes low = n * kHalfPiLow - ((first - second) - middle);
  Lanes r = second - low;
  Lanes tail = (second - r) - low;

  const LaneMask beyond = ~((angle <= broadcast(kLargestReduced)) & (angle >= broadcast(-kLargestReduced)));
  if (bits(beyond) != 0) [[unlikely]] {
    const Reduced all = reduced_in_integers(angle, beyond, {r, tail, quarter});
    r = all.r, tail = all.tail, quarter = all.quarter;
  }

  const Lanes z = r * r;
  const Lanes half = 0.5 * z;
  const Lanes one_less = 1.0 - half;
  const Lanes sin_r = r + (r * z * polynomial(kSin, z) + tail * one_less);
  const Lanes cos_r = one_less + (((1.0 - one_less) - half) + (z * z * polynomial(kCos, z) - r * tail));

  const LaneMask swap = -(quarter & 1);
  const LaneMask sin_sign = (quarter & 2) << 62;
  const LaneMask cos_sign = ((quarter + 1) & 2) << 62;
  return {(Lanes)((LaneMask)select(swap, cos_r, sin_r) ^ sin_sign),
          (Lanes)((LaneMask)select(swap, sin_r, cos_r) ^ cos_sign)};
}

}  // namespace plannercheck
