#include "math/spatial_partition.hpp"

#include <algorithm>

namespace plannercheck {
namespace {

// The axis along which the points spread furthest.
int widest_axis(const std::vector<Vec3>& points, IndexRange range) {
  int widest = 0;
  double most = -1;
  for (int axis = 0; axis < 3; ++axis) {
    double low = points[at(*range.first)][axis], high = low;
    for (const std::int32_t* i = range.first; i != range.last; ++i) {
      low = smaller(low, points[at(*i)][axis]);
      high = larger(high, points[at(*i)][axis]);
    }
    if (high - low > most) most = high - low, widest = axis;
  }
  return widest;
}

void cut(const std::vector<Vec3>& points, IndexRange range, std::ptrdiff_t capacity, std::vector<IndexRange>& parts) {
  const std::ptrdiff_t units = (range.size() + capacity - 1) / capacity;
  if (units <= 1) return parts.push_back(range);
  const int axis = widest_axis(points, range);
  std::int32_t* middle = range.first + (units / 2) * capacity;
  std::nth_element(range.first, middle, range.last, [&](std::int32_t a, std::int32_t b) {
    const double on_a = points[at(a)][axis], on_b = points[at(b)][axis];
    return on_a != on_b ? on_a < on_b : a < b;
  });
  cut(points, {range.first, middle}, capacity, parts);
  cut(points, {middle, range.last}, capacity, parts);
}

}  // namespace

std::vector<IndexRange> spatial_partition(const std::vector<Vec3>& points, IndexRange range, std::ptrdiff_t capacity) {
  std::vector<IndexRange> parts;
  if (range.size() > 0) cut(points, range, capacity, parts);
  return parts;
}

}  // namespace plannercheck
