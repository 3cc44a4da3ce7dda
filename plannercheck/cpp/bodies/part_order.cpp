#include "bodies/part_order.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "math/vec.hpp"

namespace plannercheck {
namespace {

typedef std::int32_t Four __attribute__((vector_size(16)));  // a part, with its index

// Parts of a node are sorted at once if they are no more than these, whose ranks are counted.
constexpr std::size_t kSmallNode = kChildren * kPartsInLeaf;
// The key of a part in a small node has its number there in the lowest bits, below its place along an axis.
constexpr int kNumberBits = 6;
static_assert(1 << kNumberBits == kSmallNode && kPlaceBits + kNumberBits < 32);

// Places are counted in as many bins along an axis.
constexpr int kBinBits = 8;
constexpr std::size_t kBins = 1 << kBinBits;
// Neighbours in the input are mostly in one bin: each of some in a row counts in a table of its own, and none waits.
constexpr std::size_t kTables = 4;

// Lowest and highest places along an axis.
struct Span {
  std::int32_t low, high;
};

struct LongSide {
  std::size_t axis;
  Span span;
};

class TreeOrder {
 public:
  explicit TreeOrder(PlacedParts parts) : parts_(std::move(parts)), spare_(parts_.size()) {
    std::size_t child = kPartsInLeaf;
    while (child * kChildren < parts_.size()) child *= kChildren;
    divide_node(0, parts_.size(), child);
  }

  PartIndices indices() const {
    PartIndices out(parts_.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = parts_[i].index;
    return out;
  }

 private:
  PlacedParts parts_, spare_;
  std::array<std::array<std::uint32_t, kBins>, kTables> counted_;

  // `child`: how many parts are below a child.
  void divide_node(std::size_t from, std::size_t to, std::size_t child) {
    if (to - from <= kPartsInLeaf) return;
    halve(from, to, child, kChildren);
    if (child == kPartsInLeaf) return;
    for (std::size_t first = from; first < to; first += child) {
      divide_node(first, std::min(to, first + child), child / kChildren);
    }
  }

  void halve(std::size_t from, std::size_t to, std::size_t child, std::size_t children) {
    const std::size_t half = children / 2, middle = from + half * child;
    if (middle < to) {
      if (to - from <= kSmallNode) {
        sort_few(from, to);
      } else {
        part_at(from, to, middle);
      }
    }
    if (half == 1) return;
    halve(from, std::min(middle, to), child, half);
    if (middle < to) halve(middle, to, child, half);
  }

  // Sorts along the longest side: no two keys are equal, so that each part's rank is how many are below its own.
  void sort_few(std::size_t from, std::size_t to) {
    const std::size_t count = to - from, axis = longest_side(from, to).axis;
    std::array<PlacedPart, kSmallNode> given;
    std::array<std::int32_t, kSmallNode> keys, ranks{};
    keys.fill(std::numeric_limits<std::int32_t>::max());
    for (std::size_t i = 0; i < count; ++i) {
      given[i] = parts_[from + i];
      keys[i] = given[i].at[axis] << kNumberBits | static_cast<std::int32_t>(i);
    }
    const std::size_t padded = (count + kPartsInLeaf - 1) / kPartsInLeaf * kPartsInLeaf;
    for (std::size_t j = 0; j < count; ++j) {
      const std::int32_t key = keys[j];
      for (std::size_t i = 0; i < padded; ++i) ranks[i] += key < keys[i] ? 1 : 0;
    }
    for (std::size_t i = 0; i < count; ++i) parts_[from + at(ranks[i])] = given[i];
  }

  // Afterwards no part before `middle` is beyond one after it, along the longest side. Parts are counted in bins along
  // it; those of the bin that `middle` falls into are counted again, in finer ones.
  void part_at(std::size_t from, std::size_t to, std::size_t middle) {
    auto [axis, span] = longest_side(from, to);
    while (from < middle && middle < to && span.low < span.high) {
      const auto width = static_cast<std::uint32_t>(span.high - span.low);
      const int shift = std::max(0, static_cast<int>(std::bit_width(width)) - kBinBits);
      count_bins(from, to, axis, span.low, shift);
      std::size_t below = from;
      std::int32_t bin = 0;
      for (; below + counted_[0][at(bin)] <= middle; ++bin) below += counted_[0][at(bin)];
      const std::size_t beyond = below + counted_[0][at(bin)];
      put_bin(from, to, axis, span.low, shift, bin);
      from = below, to = beyond;
      span.low += bin << shift, span.high = span.low + (1 << shift) - 1;
    }
  }

  void count_bins(std::size_t from, std::size_t to, std::size_t axis, std::int32_t low, int shift) {
    for (auto& table : counted_) table.fill(0);
    const PlacedPart* const parts = parts_.data();
    const auto bin = [&](std::size_t i) { return at((parts[i].at[axis] - low) >> shift); };
    std::size_t i = from;
    for (; i + kTables <= to; i += kTables) {
      for (std::size_t k = 0; k < kTables; ++k) ++counted_[k][bin(i + k)];
    }
    for (; i < to; ++i) ++counted_[0][bin(i)];
    for (std::size_t k = 1; k < kTables; ++k) {
      for (std::size_t b = 0; b < kBins; ++b) counted_[0][b] += counted_[k][b];
    }
  }

  // Splits parts into those before a bin, in it and after it. Each part is written to all three places, and the next
  // part overwrites two: there is no branch to mispredict. Parts in the bin are kept from the end of the spare room on.
  void put_bin(std::size_t from, std::size_t to, std::size_t axis, std::int32_t low, int shift, std::int32_t bin) {
    PlacedPart *before = parts_.data() + from, *after = spare_.data(), *inside = spare_.data() + spare_.size();
    PlacedPart* const end = inside;
    const PlacedPart* const parts = parts_.data();
    for (std::size_t i = from; i < to; ++i) {
      const PlacedPart part = parts[i];
      const std::int32_t here = (part.at[axis] - low) >> shift;
      *before = part, *after = part, *(inside - 1) = part;
      before += here < bin ? 1 : 0, after += here > bin ? 1 : 0, inside -= here == bin ? 1 : 0;
    }
    std::copy(spare_.data(), after, std::copy(inside, end, before));
  }

  LongSide longest_side(std::size_t from, std::size_t to) const {
    const auto place = [&](std::size_t i) {
      Four four;  // with the index, which is not looked at
      std::memcpy(&four, &parts_[i], sizeof four);
      return four;
    };
    Four low = place(from), high = low;
    for (std::size_t i = from + 1; i < to; ++i) {
      const Four here = place(i);
      low = here < low ? here : low, high = here > high ? here : high;
    }
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (high[k] - low[k] > high[longest] - low[longest]) longest = k;
    }
    return {longest, {low[longest], high[longest]}};
  }
};

}  // namespace

PartIndices tree_order(PlacedParts parts) { return TreeOrder(std::move(parts)).indices(); }

PartIndices tile_order(std::size_t tiles_x, std::size_t tiles_y) {
  std::size_t side = 1;
  while (side < tiles_x || side < tiles_y) side *= 2;
  PartIndices order;
  order.reserve(tiles_x * tiles_y);
  const auto visit = [&](const auto& self, std::size_t i, std::size_t j, std::size_t size) -> void {
    if (i >= tiles_x || j >= tiles_y) return;
    if (size == 1) return order.push_back(static_cast<std::int32_t>(i * tiles_y + j));
    const std::size_t half = size / 2;
    self(self, i, j, half), self(self, i, j + half, half), self(self, i + half, j, half);
    self(self, i + half, j + half, half);
  };
  visit(visit, 0, 0, side);
  return order;
}

}  // namespace plannercheck
