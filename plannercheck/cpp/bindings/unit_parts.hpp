// Which numbers of a configuration form unit vectors (quaternions, cosine and sine), and whether their lengths are as
// good as 1.
//
// In: columns, first and past the last; by how much lengths may be off. Out: whether a configuration's lengths are
// surely off by no more. robots/unit_lengths.py decides about the other configurations: it adds up the lengths along
// each chain.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bindings/array_types.hpp"

namespace plannercheck {

class UnitParts {
 public:
  UnitParts(InputArray<std::int32_t, -1, 2> columns, double tolerance) : tolerance_(tolerance) {
    for (std::size_t i = 0; i < columns.shape(0); ++i)
      parts_.emplace_back(static_cast<std::size_t>(columns(i, 0)), static_cast<std::size_t>(columns(i, 1)));
  }

  // Squares of lengths near 1 are off by twice as much as the lengths, which is far more than their rounding.
  bool are_unit(const double* q) const {
    for (const auto& [first, past] : parts_) {
      double square = 0;
      for (std::size_t i = first; i < past; ++i) square += q[i] * q[i];
      if (!(std::fabs(square - 1) <= tolerance_)) return false;
    }
    return true;
  }
  // As above, for n configurations of `width` numbers.
  bool are_unit(const double* q, std::size_t n, std::size_t width) const {
    if (parts_.empty()) return true;
    for (std::size_t i = 0; i < n; ++i) {
      if (!are_unit(q + i * width)) return false;
    }
    return true;
  }

 private:
  std::vector<std::pair<std::size_t, std::size_t>> parts_;
  double tolerance_;
};

}  // namespace plannercheck
