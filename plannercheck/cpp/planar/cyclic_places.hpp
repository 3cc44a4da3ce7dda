// Three places on a cyclic array, in order, and the remaining part of the array: first the whole cycle, cut in three;
// later the chain from the first place to the last.
//
// The walk of polygon_test.cpp narrows two of these: A's vertices and B's edges.
#pragma once

#include <array>
#include <cstddef>

namespace plannercheck {

// Successor and predecessor of 0, 1, 2 in their cycle.
inline constexpr std::array<std::size_t, 3> kNext{1, 2, 0}, kPrevious{2, 0, 1};

// The places are stored in any order; `order` lists them along the array.
struct CyclicPlaces {
  std::size_t count;              // of the array
  std::array<std::size_t, 3> at;  // as stored
  std::array<std::size_t, 3> order{0, 1, 2};
  bool closed = true;

  CyclicPlaces(std::size_t n, const std::array<std::size_t, 3>& first) : count(n), at(first) {}

  // The number of steps from the k-th place to the next one, within the part that is left.
  std::size_t steps(std::size_t k) const {
    if (k == 2 && !closed) return 0;
    const std::size_t from = at[order[k]], to = at[order[kNext[k]]];
    return to + (to < from ? count : 0) - from;
  }
  std::size_t after(std::size_t index) const { return index + 1 == count ? 0 : index + 1; }
  std::size_t before(std::size_t index) const { return (index == 0 ? count : index) - 1; }
  std::size_t halfway(std::size_t k) const {
    const std::size_t index = at[order[k]] + steps(k) / 2;
    return index - (index < count ? 0 : count);
  }
  // Keeps the chain from the k-th place to the next one and adds a place halfway, stored in the slot of the third one.
  std::size_t keep(std::size_t k) {
    const std::size_t middle = halfway(k), from = order[k], to = order[kNext[k]], third = order[kPrevious[k]];
    at[third] = middle;
    order = {from, third, to};
    closed = false;
    return third;
  }
};

}  // namespace plannercheck
