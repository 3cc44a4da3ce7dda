#include "bodies/part_order.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace plannercheck {
namespace {

class TreeOrder {
 public:
  explicit TreeOrder(std::vector<PlacedPart> parts) : parts_(std::move(parts)) {
    std::size_t child = kPartsInLeaf;
    while (child * kChildren < parts_.size()) child *= kChildren;
    divide_node(0, parts_.size(), child);
  }

  std::vector<std::int32_t> indices() const {
    std::vector<std::int32_t> out(parts_.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = parts_[i].index;
    return out;
  }

 private:
  static constexpr std::size_t kSamples = 9;  // of which the middle one is the pivot

  std::vector<PlacedPart> parts_;

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
      const std::size_t axis = longest_side(from, to);
      part_at(from, to, middle, axis);
    }
    if (half == 1) return;
    halve(from, std::min(middle, to), child, half);
    if (middle < to) halve(middle, to, child, half);
  }

  // Hoare's selection (1961): afterwards no part before `middle` is beyond one after it, along the axis. Parts are
  // moved without a branch that can't be foreseen.
  void part_at(std::size_t from, std::size_t to, std::size_t middle, std::size_t axis) {
    while (to - from > 1) {
      const float pivot = pivot_of(from, to, axis);
      const std::size_t below = parted(from, to, [&](const PlacedPart& part) { return part.at[axis] < pivot; });
      if (middle < below) {
        to = below;
        continue;
      }
      const std::size_t equal = parted(below, to, [&](const PlacedPart& part) { return part.at[axis] <= pivot; });
      if (middle < equal) return;
      from = equal;
    }
  }

  // Puts those first for which a condition holds, and says how far they reach.
  template <class Condition>
  std::size_t parted(std::size_t from, std::size_t to, Condition holds) {
    PlacedPart* const parts = parts_.data();
    std::size_t end = from;
    for (std::size_t i = from; i < to; ++i) {
      const PlacedPart part = parts[i];
      parts[i] = parts[end];
      parts[end] = part;
      end += holds(part) ? 1 : 0;
    }
    return end;
  }

  float pivot_of(std::size_t from, std::size_t to, std::size_t axis) const {
    const std::size_t step = (to - from) / kSamples;
    if (step == 0) return parts_[from + (to - from) / 2].at[axis];
    std::array<float, kSamples> samples;
    for (std::size_t k = 0; k < kSamples; ++k) samples[k] = parts_[from + k * step + step / 2].at[axis];
    std::sort(samples.begin(), samples.end());
    return samples[kSamples / 2];
  }

  std::size_t longest_side(std::size_t from, std::size_t to) const {
    typedef float Four __attribute__((vector_size(16)));
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
    return longest;
  }
};

}  // namespace

std::vector<std::int32_t> tree_order(std::vector<PlacedPart> parts) { return TreeOrder(std::move(parts)).indices(); }

std::vector<std::int32_t> tile_order(std::size_t tiles_x, std::size_t tiles_y) {
  std::size_t side = 1;
  while (side < tiles_x || side < tiles_y) side *= 2;
  std::vector<std::int32_t> order;
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
