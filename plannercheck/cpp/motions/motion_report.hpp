// How the check of a motion ended, in space and in the plane.
#pragma once

#include <cstdint>

namespace plannercheck {

enum class MotionAnswer : int {
  kFree,
  kRefused,    // proved to come within the tolerance
  kImprecise,  // numbers so large that rounding exceeds a part of the tolerance
};

// Where a check ended: at `refused` the pair is within the tolerance; up to `free_until` the motion is proved free, if
// it was looked at in order.
struct MotionReport {
  MotionAnswer answer = MotionAnswer::kFree;
  double free_until = 1, refused = -1;
  std::int32_t pair = -1;
};

}  // namespace plannercheck
