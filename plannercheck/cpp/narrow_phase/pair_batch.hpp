// Many poses of the same two bodies.
//
// A test of large bodies mostly waits for memory: each step of a descent reads what the step before leads to. Tests of
// different poses are independent, so several are interleaved: each does a step and prefetches what its next one reads
// while the others do theirs. Poses close to the ones before find their memory in the cache and are tested at once.
// Verdicts equal those of the tests one by one. Without cached planes, so do certificates, stages and counters; with
// them, only poses that follow others try a plane, the latest one kept, which need not be that of the pair before.
#pragma once

#include <cstddef>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

// Where poses come from and verdicts go to.
class PairBatch {
 public:
  virtual PosedPolytope guest(std::size_t i) const = 0;
  virtual PosedPolytope host(std::size_t i) const = 0;
  virtual void take(std::size_t i, const PairVerdict& verdict) = 0;
  // For bodies whose balls are apart, which are many: batches that need no certificate replace this. No plane is kept
  // of them, since the next pose tries the same axis before a kept plane.
  virtual void take_far(std::size_t i, const CentreAxis& axis) { take(i, certified(axis.separated(false), nullptr)); }

 protected:
  ~PairBatch() = default;
};

// Tests the same two bodies at all poses; verdicts come in any order.
void test_pairs(const Polytope& guest, const Polytope& host, std::size_t pairs, const PairOptions& options,
                PairBatch& batch, PairCounters& counters);

}  // namespace plannercheck
