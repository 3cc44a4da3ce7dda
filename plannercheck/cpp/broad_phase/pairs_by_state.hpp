// The pairs in cells (apart_cells.hpp) that may meet in the states of a block, looked up in lanes.
//
// In: cells, the block's configurations. Out: for each state a bit a pair, and for each pair a bit a state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "broad_phase/apart_cells.hpp"
#include "broad_phase/block_configurations.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class PairsByState {
 public:
  // All of them.
  PairsByState() { eights_.fill(~std::uint64_t{0}); }
  PairsByState(const ApartCells& cells, const BlockConfigurations& q) {
    const auto& [first, second] = cells.columns();
    for (std::size_t group = 0; group < kBlockGroups; ++group) {
      const Lanes* const numbers = q.columns + group * q.width;
      const auto rows = __builtin_convertvector(ApartCells::place(first, numbers[first.column]), LaneIndices);
      const auto own = __builtin_convertvector(ApartCells::place(second, numbers[second.column]), LaneIndices);
      const LaneIndices places = rows * cells.row_length() + own;
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t state = group * kLanes + lane;
        eights_[state / 8] |= static_cast<std::uint64_t>(cells.at_place(places[lane])) << (state % 8 * 8);
      }
    }
  }

  // The pairs that may meet in any of them.
  unsigned in_any() const {
    std::uint64_t any = 0;
    for (std::size_t k = 0; k < kEights; ++k) any |= eights_[k];
    any |= any >> 32U, any |= any >> 16U, any |= any >> 8U;
    return static_cast<unsigned>(any & 0xff);
  }

  // The states in which a pair may meet, a bit each.
  unsigned states_of(std::size_t pair) const {
    unsigned out = 0;
    for (std::size_t k = 0; k < kEights; ++k) {
      // One bit of each byte, put side by side by a product none of whose parts overlap.
      const std::uint64_t bits = (eights_[k] >> pair & 0x0101010101010101U) * 0x0102040810204080U >> 56U;
      out |= static_cast<unsigned>(bits) << (8 * k);
    }
    return out;
  }

 private:
  static constexpr std::size_t kEights = kBlockStates / 8;
  static_assert(kEights * 8 == kBlockStates);

  std::array<std::uint64_t, kEights> eights_{};  // state 8 k + i: byte i of eight k, from the lowest on
};

}  // namespace plannercheck
