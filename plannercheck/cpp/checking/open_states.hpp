// States that filters left open at poses in floats, with their open pairs, collected until they fill a block; and the
// recent share of open states.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "broad_phase/near_pairs.hpp"
#include "broad_phase/state_block.hpp"
#include "math/recent_rate.hpp"

namespace plannercheck {

class OpenStates {
 public:
  // `pairs`: how many the checker has. Memory is reserved for a few near pairs a state.
  explicit OpenStates(std::size_t pairs = 0) { pairs_.reserve(kMost * (pairs < kFew ? pairs : kFew)); }

  std::size_t size() const { return size_; }

  // Adds a row of the set, with the pairs that are near.
  void add(std::size_t row, const std::vector<std::int32_t>& near) {
    states_[size_++] = {row, pairs_.size()};
    pairs_.insert(pairs_.end(), near.begin(), near.end());
  }

  // Takes up to a block of the states added last: writes their rows, and what was found of them, from the block's first
  // state on.
  std::size_t take(std::array<std::size_t, kBlockStates>& rows, Found& found) {
    const std::size_t count = size_ < kBlockStates ? size_ : kBlockStates;
    found.begin();
    for (std::size_t k = 0; k < count; ++k) {
      const State& last = states_[--size_];
      rows[k] = last.row;
      found.near.add(k, pairs_.begin() + static_cast<std::ptrdiff_t>(last.first), pairs_.end());
      pairs_.resize(last.first);
    }
    return count;
  }

  // Whether few enough states are left open lately for floats to save time; now and then, to see whether that still
  // holds.
  bool floats_pay() { return open_.is_at_most(kMostOpen) || open_.is_due(); }
  void learn(std::size_t judged, std::size_t open) {
    if (!open_.is_at_most(kMostOpen)) open_.halve();  // a block that is tried counts as much as all before it
    open_.add(static_cast<std::uint32_t>(judged), static_cast<std::uint32_t>(open));
  }

 private:
  // Poses in floats take about a third of the time of those in doubles, which states left open take besides (measured).
  static constexpr double kMostOpen = 0.65;
  static constexpr std::size_t kFew = 16;
  static constexpr std::size_t kMost = 2 * kBlockStates;  // less than a block, and a block more

  struct State {
    std::size_t row, first;  // of its pairs, which end where the next state's begin
  };

  std::size_t size_ = 0;
  std::array<State, kMost> states_{};
  std::vector<std::int32_t> pairs_;
  // The share of the states posed in floats that stay open. It begins with 256 decided states, so that the first block
  // does not settle it alone (all measured).
  RecentRate open_{1024, 128, 256, 0};
};

}  // namespace plannercheck
