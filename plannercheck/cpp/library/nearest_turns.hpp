// Angles less whole turns, within half a turn of others: the very doubles of plannercheck/common/angles.py, which
// proves the rounding.
#pragma once

#include <cmath>
#include <numbers>

namespace plannercheck {

// 2π is the sum of these two up to 6e-33.
inline constexpr double kTurn = 2 * std::numbers::pi, kTurnRest = 2.4492935982947064e-16;

// angle − 2π turns, rounded once (Dekker's product, Knuth's difference).
inline double unwound(double angle, double turns) {
  constexpr double kSplitter = 0x1p27 + 1;  // Veltkamp's, which cuts a double into two of 26 bits
  constexpr double kHigh = kSplitter * kTurn - (kSplitter * kTurn - kTurn), kLow = kTurn - kHigh;
  const double product = kTurn * turns, cut = kSplitter * turns;
  const double high = cut - (cut - turns), low = turns - high;
  const double lost = ((kHigh * high - product) + kHigh * low + kLow * high) + kLow * low;
  const double difference = angle - product, back = difference - angle;
  const double left = (angle - (difference - back)) - (product + back);
  return difference + ((left - lost) - kTurnRest * turns);
}

// How many whole turns longer than need be a way is; 0 for up to half a turn.
inline double turns_too_many(double way) {
  const double length = std::fabs(way);
  return length > std::numbers::pi ? std::copysign(std::nearbyint(length / kTurn), way) : 0;
}

// The end less whole turns, within half a turn of the start; with its bits if it is there already.
inline double nearest_turn(double start, double end) {
  double turns = turns_too_many(end - start);
  if (turns == 0) return end;
  const double near = unwound(end, turns);
  const double more = turns_too_many(near - start);  // far from 0 the ways are rounded
  if (more == 0) return near;
  turns += more;
  return turns == 0 ? end : unwound(end, turns);
}

}  // namespace plannercheck
