// Many poses of the same two bodies.
//
// A test of large bodies waits for memory most of its time: each step of a descent reads what the one before has led
// to. Tests of different poses have nothing to do with each other, so several are under way at a time: each does a
// step, asks for the memory that its next one reads, and the others' steps follow meanwhile. Poses about the same as
// those before find their memory in the cache and are tested at once. Verdicts are those of the tests one by one; so
// are certificates, stages and counters without cached planes: with them, only poses that follow others try one, the
// latest that was left, which need not be that of the pair before.
#pragma once

#include <cstddef>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

// Where poses come from and verdicts go to.
class PairBatch {
 public:
  virtual PosedBody guest(std::size_t i) const = 0;
  virtual PosedBody host(std::size_t i) const = 0;
  virtual void take(std::size_t i, const PairVerdict& verdict) = 0;
  // Of bodies whose balls are apart, which are many: for batches that need no certificate.
  virtual void take_far(std::size_t i, const CentreAxis& axis) { take(i, certified(axis.separated(false), nullptr)); }

 protected:
  ~PairBatch() = default;
};

// Of two bodies, the same in all pairs; verdicts come in any order.
void test_pairs(const Body& guest, const Body& host, std::size_t pairs, const PairOptions& options, PairBatch& batch,
                PairCounters& counters);

}  // namespace plannercheck
