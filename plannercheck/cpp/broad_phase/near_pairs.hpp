// The filters' result for a block: the states that surely collide, and the pairs that stay open in the other states.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "broad_phase/state_block.hpp"

namespace plannercheck {

// Pairs that no filter has decided, by state.
class NearPairs {
 public:
  void reserve(std::size_t pairs) {
    for (std::vector<std::int32_t>& of_state : pairs_) of_state.reserve(pairs);
  }
  void clear() {
    for (; states_ != 0; states_ &= states_ - 1) pairs_[static_cast<std::size_t>(__builtin_ctz(states_))].clear();
    count_ = 0;
  }

  void add(std::int32_t pair, unsigned states) {
    states_ |= states;
    count_ += __builtin_popcount(states);
    for (; states != 0; states &= states - 1) pairs_[static_cast<std::size_t>(__builtin_ctz(states))].push_back(pair);
  }
  template <class Iterator>
  void add(std::size_t state, Iterator first, Iterator past) {
    pairs_[state].insert(pairs_[state].end(), first, past);
    states_ |= first != past ? 1U << state : 0;
    count_ += past - first;
  }

  // The states with a pair, a bit each.
  unsigned states() const { return states_; }
  long count() const { return count_; }
  std::vector<std::int32_t>& of(std::size_t state) { return pairs_[state]; }

 private:
  std::array<std::vector<std::int32_t>, kBlockStates> pairs_;
  unsigned states_ = 0;
  long count_ = 0;  // of all states
};

struct Found {
  NearPairs near;
  unsigned overlapping = 0;  // states, a bit each, in which some pair surely shares a point; no pair is near in these
  long boxes_apart = 0;      // pairs that boxes separate
  long skipped = 0;          // other pairs of overlapping states

  void begin() {
    near.clear();
    overlapping = 0, boxes_apart = 0, skipped = 0;
  }
};

}  // namespace plannercheck
