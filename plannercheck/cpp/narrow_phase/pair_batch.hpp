// Many poses of the same two bodies.
#pragma once

#include <cstddef>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

// Where poses come from and verdicts go to.
class PairBatch {
 public:
  virtual PosedPolytope body_a(std::size_t i) const = 0;
  virtual PosedPolytope body_b(std::size_t i) const = 0;
  virtual void take(std::size_t i, const PairVerdict& verdict) = 0;
  // For bodies whose balls are apart, which are many: batches that need no certificate replace this. No plane is kept
  // of them, since the next pose tries the same axis before a kept plane.
  virtual void take_far(std::size_t i, const CentreAxis& axis) { take(i, certified(axis.separated(false), nullptr)); }

 protected:
  ~PairBatch() = default;
};

// Tests the same two bodies at all poses, one after another.
void test_pairs(const Polytope& body_a, const Polytope& body_b, std::size_t pairs, const PairOptions& options,
                PairBatch& batch, PairCounters& counters);

}  // namespace plannercheck
