// The pairs that overlapped most often in the latest single states: planners ask for states one by one, and most of
// those that collide do so in one of the same few pairs.
//
// In: what each state showed. Out: the pairs that are worth a try in the next state, before anything else. Pairs gain
// weight as they are found, tried or not, and lose it with every other state, so that nothing is tried where no pair
// stands out, as in random states. There, of the pairs that are near, the one that overlapped in most of all states
// goes first.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace plannercheck {

class LikelyOverlaps {
 public:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  // Of so many pairs.
  explicit LikelyOverlaps(std::size_t pairs = 0) : counts_(pairs) {}

  // The first pair for which overlaps(pair) holds, of those that are worth a try; the likeliest goes first.
  template <class Overlaps>
  std::size_t first(Overlaps overlaps) const {
    int left = kAlways;  // the weight of what has not been tried in vain
    for (const Entry& entry : entries_) {
      // The second: after very many states with the first pair, nothing is left, and there may be no other pair.
      if (kWorth * entry.weight < left || entry.pair == kNone) break;
      if (overlaps(entry.pair)) return entry.pair;
      left -= entry.weight;
    }
    return kNone;
  }

  // Candidates have a pair.
  template <class Candidate>
  void put_first(std::vector<Candidate>& candidates) const {
    if (candidates.empty()) return;
    const auto count = [&](const Candidate& candidate) { return counts_[static_cast<std::size_t>(candidate.pair)]; };
    const auto likeliest = std::max_element(candidates.begin(), candidates.end(),
                                            [&](const auto& a, const auto& b) { return count(a) < count(b); });
    std::swap(candidates.front(), *likeliest);
  }

  // Takes the pair that was found to overlap in a state, or kNone.
  void learn(std::size_t found) {
    for (Entry& entry : entries_) entry.weight -= entry.weight / kStates;
    if (found == kNone) return;
    ++counts_[found];
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
  // A pair is worth a try if it overlaps in one of so many states; with 5, random states lose 2 to 4 percent
  // (measured).
  static constexpr int kWorth = 3;
  // Weights are sums over about so many of the latest states; a pair that overlaps in each of them has kAlways.
  static constexpr int kStates = 16, kAlways = 1 << 16;
  static constexpr std::size_t kPairs = 2;

  struct Entry {
    std::size_t pair = kNone;
    int weight = 0;
  };

  std::array<Entry, kPairs> entries_{};
  std::vector<std::uint32_t> counts_;  // by pair
};

}  // namespace plannercheck
