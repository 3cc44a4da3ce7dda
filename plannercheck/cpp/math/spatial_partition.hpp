// Points in groups of neighbours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

// Some of the points: a range in an array of their indices.
struct IndexRange {
  std::int32_t *first, *last;
  std::ptrdiff_t size() const { return last - first; }
};

// Sorts a range into parts of at most `capacity` points, by cuts across the axis of largest spread; all but the last
// are full.
std::vector<IndexRange> spatial_partition(const std::vector<Vec3>& points, IndexRange range, std::ptrdiff_t capacity);

}  // namespace plannercheck
