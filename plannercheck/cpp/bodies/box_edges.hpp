// Planes along an edge of each of two boxes: by how much they separate the boxes, in doubles or in lanes.
//
// In: for boxes with axes a_i and b_j and the difference d of their centres, the products a_i b_j and a_i d, and half
// the edges. Out: for each direction a_i x b_j, the distance of the centres along it, and the sum of the boxes' half
// extents. Half edge k of the first box projects to |a_k (a_i x b_j)| of its length: 0 for k = i, else |a_m b_j| for
// the third axis m; likewise for the second box. The callers allow for axes that are off orthonormal, and for rounding:
// three products and sums in each number.
#pragma once

#include <array>
#include <cstddef>

#include "math/simd.hpp"

namespace plannercheck {

// Whether apart(distance, reach) holds for any of the nine directions, of which the first ends the search.
template <class Number, class Apart>
[[gnu::always_inline]] inline bool any_edges(const std::array<Number, 9>& product, const std::array<Number, 3>& along,
                                             const std::array<Number, 3>& half_a, const std::array<Number, 3>& half_b,
                                             Apart apart) {
  const auto shadow = [&](std::size_t place) { return absolute(product[place]); };
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t k = (i + 1) % 3, l = (i + 2) % 3;
#pragma GCC unroll 3
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t m = (j + 1) % 3, n = (j + 2) % 3;
      const Number own = multiply_add(shadow(3 * l + j), half_a[k], shadow(3 * k + j) * half_a[l]);
      const Number other = multiply_add(shadow(3 * i + n), half_b[m], shadow(3 * i + m) * half_b[n]);
      const Number distance = multiply_subtract(along[l], product[3 * k + j], along[k] * product[3 * l + j]);
      if (apart(absolute(distance), own + other)) return true;
    }
  }
  return false;
}

}  // namespace plannercheck
