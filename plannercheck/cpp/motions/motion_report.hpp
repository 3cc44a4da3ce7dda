// The result and the counts of a motion's check, in space (directions are Vec3) and in the plane (PlanarDirection).
#pragma once

#include <cstdint>

namespace plannercheck {

enum class MotionAnswer : int {
  kFree,
  kRefused,    // proved to come within the tolerance
  kImprecise,  // numbers so large that rounding exceeds its part of the tolerance
};

// Where a check ended: at `refused` the pair is within the tolerance; up to `free_until` it is proved free, if checked
// in order.
struct MotionReport {
  MotionAnswer answer = MotionAnswer::kFree;
  double free_until = 1, refused = -1;
  std::int32_t pair = -1;
};

// What proves a pair apart on an interval: at both ends the bodies are `gap` apart along `direction` (in the pair's
// frame, from b to a), while their points leave their chords by at most `chord_deviation`, which is less than the gap.
template <class Direction>
struct IntervalProof {
  std::int32_t pair;
  double from, to;
  Direction direction;
  double gap, chord_deviation;
};

// The result of a descent on the swept bodies, at all poses given.
template <class Direction>
struct SweptAnswer {
  bool apart = false;   // proved: more than the limit apart along `direction`
  Direction direction;  // in the pair's frame, from b to a, of length 1 up to rounding
  double gap = 0;       // along `direction`: a lower bound up to rounding, which the limit has to cover
  // How deep the origin is inside some of the bodies' differences, up to rounding, where the descent has found that: if
  // this exceeds what a difference errs by, and there is one pose, the bodies share a point there.
  double inside = 0;
};

struct GridCounters {
  long motions = 0, grids = 0, states = 0;
  long pairs = 0, intervals = 0;  // on grids; intervals that bounding spheres or circles leave open
  long planes = 0, swept = 0;     // evaluated gaps along planes (lines in the plane), and descents
};

inline GridCounters& operator+=(GridCounters& sum, const GridCounters& more) {
  sum.motions += more.motions, sum.grids += more.grids, sum.states += more.states;
  sum.pairs += more.pairs, sum.intervals += more.intervals, sum.planes += more.planes, sum.swept += more.swept;
  return sum;
}

}  // namespace plannercheck
