// The rest of a large angle after all whole quarters of a turn, in integers (Payne and Hanek).
//
// In: a double of at least 1 rad. Out: the rest as a sum of two doubles, and the quarter of the turn, the same bits on
// every machine. Idea: an angle is mantissa * 2^exponent, so only 192 bits of 2/pi matter: the bits before them give
// whole turns, the bits after them less than 2^-137 of a quarter. The rest, in units of 2^-128 quarters, times pi/2
// errs by less than 2^-126 rad. No double is closer to a multiple of pi/2 than 2^-62, so even then 64 bits are right.
#pragma once

namespace plannercheck {

struct ReducedAngle {
  double rest, tail;  // angle = whole turns + quarter * pi/2 + rest + tail, |rest| <= pi/4, |tail| <= ulp(rest) / 2
  unsigned quarter;   // 0 ... 3
};

// NaN if the angle is not finite.
ReducedAngle reduced(double angle);

}  // namespace plannercheck
