// The pairs that overlapped most often in the latest single states: planners ask for states one by one, and most of
// those that collide do so in one of the same few pairs.
//
// In: what each state showed. Out: the pairs that are worth a try in the next state, before anything else. Pairs gain
// weight as they are found, tried or not, and lose it with every other state, so that nothing is tried where no pair
// stands out, as in random states.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

namespace plannercheck {

class LikelyOverlaps {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  // The first pair for which overlaps(pair) holds, of those that are worth a try; the likeliest goes first.
  template <class Overlaps>
  std::size_t first(Overlaps overlaps) const {
    int left = kAlways;  // the weight of what has not been tried in vain
    for (const Entry& entry : entries_) {
      if (kWorth * entry.weight < left) break;
      if (overlaps(entry.pair)) return entry.pair;
      left -= entry.weight;
    }
    return kNone;
  }

  // Takes the pair that was found to overlap in a state, or kNone.
  void learn(std::size_t found) {
    for (Entry& entry : entries_) entry.weight -= entry.weight / kStates;
    if (found == kNone) return;
    bool is_known = false;
    for (std::size_t k = 0; k < kPairs; ++k) {
      Entry& entry = entries_[k];
      if (entry.pair != found) continue;
      is_known = true;
      entry.weight += kAlways / kStates;
      if (k > 0 && entries_[k - 1].weight < entry.weight) std::swap(entries_[k - 1], entry);
    }
    if (!is_known) entries_.back() = {found, kAlways / kStates};
  }

 private:
  // A try takes about an eighth of what it saves (measured).
  static constexpr int kWorth = 3;
  // Weights are sums over about so many of the latest states; a pair that overlaps in each of them has kAlways.
  static constexpr int kStates = 16, kAlways = 1 << 16;
  static constexpr std::size_t kPairs = 2;

  struct Entry {
    std::size_t pair = kNone;
    int weight = 0;
  };

  std::array<Entry, kPairs> entries_{};
};

}  // namespace plannercheck
