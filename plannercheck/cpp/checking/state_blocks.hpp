// Configurations in lanes: blocks of rows as given, or of states along a straight motion, coarse to fine.
//
// Number c of a block's state s is lane s % kLanes of columns[s / kLanes * width + c]. Lanes past the last state repeat
// it, so that every lane holds a configuration.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "math/interruption.hpp"
#include "math/simd.hpp"

namespace plannercheck {

// n rows of `width` numbers, as the first of `states`; row_at(k): where the k-th is.
template <std::size_t states, class Row>
void load_rows(Row row_at, std::size_t n, std::size_t width, Lanes* columns) {
  for (std::size_t group = 0; group < states / kLanes; ++group) {
    std::array<const double*, kLanes> row;
    for (std::size_t lane = 0; lane < kLanes; ++lane) row[lane] = row_at(std::min(group * kLanes + lane, n - 1));
    for (std::size_t c = 0; c < width; ++c) {
      Lanes column{};  // built in a register: a wide load after narrow stores would be a store-forwarding stall
      for (std::size_t lane = 0; lane < kLanes; ++lane) column[lane] = row[lane][c];
      columns[group * width + c] = column;
    }
  }
}

// Whether the states (1 − t) q0 + t q1 at t = 0, 1/steps, …, 1 are all free, by blocks of `states`; coarse to fine, so
// that a collision is met early. all_free(n) says whether the first n states of the columns are free.
template <std::size_t states, class AllFree>
bool is_free_coarse_to_fine(const double* q0, const double* q1, long steps, std::size_t width, Lanes* columns,
                            AllFree all_free) {
  const auto every = [&](long first, long stride, long last) {
    for (long k = first; k <= last; k += stride * static_cast<long>(states)) {
      poll_interruption();
      const long count = std::min<long>(states, (last - k) / stride + 1);
      for (std::size_t group = 0; group < states / kLanes; ++group) {
        Lanes t;
        for (long lane = 0; lane < kLanes; ++lane) {
          const long state = std::min(static_cast<long>(group) * kLanes + lane, count - 1);
          t[lane] = static_cast<double>(k + stride * state) / static_cast<double>(steps);
        }
        for (std::size_t c = 0; c < width; ++c) columns[group * width + c] = (1 - t) * q0[c] + t * q1[c];
      }
      if (!all_free(static_cast<std::size_t>(count))) return false;
    }
    return true;
  };
  if (!every(0, steps, steps)) return false;
  long stride = 1;
  while (stride < steps) stride *= 2;
  for (; stride > 1; stride /= 2) {
    if (!every(stride / 2, stride, steps - 1)) return false;
  }
  return true;
}

}  // namespace plannercheck
