// The pairs that overlapped most often in the latest states: along motions, and in planners' states, the same few pairs
// decide most states that collide.
//
// In: the overlaps of each state, or block of states. Out: the pairs to test first in the next states; none if no pair
// stands out, as in random states.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "math/recent_rate.hpp"

namespace plannercheck {

class LikelyOverlaps {
 public:
  // Calls overlaps(pair) for pairs that are worth a try, the likeliest first, until it returns true.
  template <class Overlaps>
  void try_each(Overlaps overlaps) const {
    for (const Entry& entry : entries_) {
      if (!entry.rate.is_at_least_one_in(kWorth) || overlaps(entry.pair)) return;
    }
  }

  // Takes the overlaps of the latest states: `pair` overlapped in `overlapping` of `states`; 0 says that no pair did.
  void learn(std::size_t pair, int states, int overlapping) {
    const auto all = static_cast<std::uint32_t>(states), some = static_cast<std::uint32_t>(overlapping);
    bool is_known = some == 0;
    for (Entry& entry : entries_) {
      is_known |= entry.pair == pair;
      entry.rate.add(all, entry.pair == pair ? some : 0);
    }
    if (!is_known) {
      entries_[1] = {pair, kUnknown};
      entries_[1].rate.add(all, some);
    }
    if (entries_[1].rate.is_above(entries_[0].rate)) std::swap(entries_[0], entries_[1]);
  }

 private:
  // A pair is worth a try if it overlaps in one of so many states; with 5, random states lose 2 to 4 percent
  // (measured).
  static constexpr std::uint32_t kWorth = 3;
  static constexpr RecentRate kUnknown{32, 1, 16, 1};

  struct Entry {
    std::size_t pair = static_cast<std::size_t>(-1);  // none: its rate never rises
    RecentRate rate = kUnknown;
  };

  std::array<Entry, 2> entries_{};
};

}  // namespace plannercheck
