// States that filters left open after poses in floats, with the pairs that are near, kept until there are enough for a
// block; and how many are left open lately.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "broad_phase/state_block.hpp"

namespace plannercheck {

class OpenStates {
 public:
  std::size_t size() const { return size_; }
  void clear() { size_ = 0; }

  // Of the row of a set. Swaps memory with `near`, whose values get lost.
  void add(std::size_t row, std::vector<std::int32_t>& near) {
    rows_[size_] = row;
    std::swap(near_[size_++], near);
  }

  // Whether few enough states are left open lately for floats to save time; now and then, to see whether that still
  // holds.
  bool floats_pay() { return kMostOpen * judged_ >= open_ || ++passed_over_ % kTriedAgain == 0; }
  void learn(std::size_t judged, std::size_t open) {
    judged_ += static_cast<double>(judged), open_ += static_cast<double>(open);
    if (judged_ > kLately) judged_ /= 2, open_ /= 2;
  }

  // Takes up to a block of those added last: their rows, and their pairs into the block's first states.
  template <class Near>
  std::size_t take(std::array<std::size_t, kBlockStates>& rows, Near& near) {
    const std::size_t count = size_ < kBlockStates ? size_ : kBlockStates;
    for (std::size_t k = 0; k < count; ++k) {
      rows[k] = rows_[--size_];
      std::swap(near[k], near_[size_]);
    }
    return count;
  }

 private:
  static constexpr std::size_t kMost = 2 * kBlockStates;  // less than a block, and a block more

  // Poses in floats take about a third of the time of those in doubles, which states left open take besides. Of the
  // states posed in floats, those of about kLately ago count half (all measured).
  static constexpr double kMostOpen = 0.65, kLately = 1024;
  static constexpr std::size_t kTriedAgain = 128;

  double judged_ = 0, open_ = 0;
  std::size_t passed_over_ = 0;  // counts the blocks for which floats did not pay
  std::size_t size_ = 0;
  std::array<std::size_t, kMost> rows_{};
  std::array<std::vector<std::int32_t>, kMost> near_;
};

}  // namespace plannercheck
