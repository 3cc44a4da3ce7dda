#include "obstacle_tree.hpp"

#include <algorithm>
#include <numeric>

namespace plannercheck {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

double twice_centre(const WorldBox& box, int axis) { return box.low[axis] + box.high[axis]; }

// The axis along which the centres spread most.
int widest_axis(const std::vector<WorldBox>& boxes, IndexRange range) {
  int widest = 0;
  double most = -1;
  for (int axis = 0; axis < 3; ++axis) {
    double low = twice_centre(boxes[at(*range.first)], axis), high = low;
    for (const std::int32_t* i = range.first; i != range.last; ++i) {
      low = smaller(low, twice_centre(boxes[at(*i)], axis));
      high = larger(high, twice_centre(boxes[at(*i)], axis));
    }
    if (high - low > most) most = high - low, widest = axis;
  }
  return widest;
}

WorldBox around(const std::vector<WorldBox>& boxes, IndexRange range) {
  WorldBox out = boxes[at(*range.first)];
  for (const std::int32_t* i = range.first; i != range.last; ++i) {
    const WorldBox& box = boxes[at(*i)];
    out.low = {smaller(out.low.x, box.low.x), smaller(out.low.y, box.low.y), smaller(out.low.z, box.low.z)};
    out.high = {larger(out.high.x, box.high.x), larger(out.high.y, box.high.y), larger(out.high.z, box.high.z)};
  }
  return out;
}

// Cuts a range into parts of at most `capacity` boxes, where its boxes spread most; all parts but one are full.
void cut(const std::vector<WorldBox>& boxes, IndexRange range, std::ptrdiff_t capacity,
         std::vector<IndexRange>& parts) {
  const std::ptrdiff_t units = (range.size() + capacity - 1) / capacity;
  if (units <= 1) return parts.push_back(range);
  const int axis = widest_axis(boxes, range);
  std::int32_t* middle = range.first + (units / 2) * capacity;
  std::nth_element(range.first, middle, range.last, [&](std::int32_t a, std::int32_t b) {
    const double ca = twice_centre(boxes[at(a)], axis), cb = twice_centre(boxes[at(b)], axis);
    return ca != cb ? ca < cb : a < b;
  });
  cut(boxes, {range.first, middle}, capacity, parts);
  cut(boxes, {middle, range.last}, capacity, parts);
}

}  // namespace

ObstacleTree::ObstacleTree(const std::vector<WorldBox>& boxes) {
  std::vector<std::int32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0);
  if (!order.empty()) build(boxes, {order.data(), order.data() + order.size()});
}

std::int32_t ObstacleTree::build(const std::vector<WorldBox>& boxes, IndexRange range) {
  std::ptrdiff_t capacity = 1;
  while (capacity * kFloats < range.size()) capacity *= kFloats;
  std::vector<IndexRange> parts;
  cut(boxes, range, capacity, parts);

  const std::size_t index = nodes_.size();
  nodes_.emplace_back();  // before its children
  Node node;
  for (std::size_t k = 0; k < kFloats; ++k) {
    const bool empty = k >= parts.size();
    const WorldBox box = empty ? WorldBox{} : around(boxes, parts[k]);
    node.low_x[k] = empty ? kInfinity : rounded_down(box.low.x),
    node.high_x[k] = empty ? -kInfinity : rounded_up(box.high.x);
    node.low_y[k] = empty ? kInfinity : rounded_down(box.low.y),
    node.high_y[k] = empty ? -kInfinity : rounded_up(box.high.y);
    node.low_z[k] = empty ? kInfinity : rounded_down(box.low.z),
    node.high_z[k] = empty ? -kInfinity : rounded_up(box.high.z);
    node.child[k] = empty ? kNothing : parts[k].size() == 1 ? ~*parts[k].first : build(boxes, parts[k]);
  }
  nodes_[index] = node;
  return static_cast<std::int32_t>(index);
}

void ObstacleTree::collect(const FloatSphere& sphere, std::vector<std::int32_t>& found) const {
  if (nodes_.empty()) return;
  std::array<std::int32_t, kFloats * kMostLevels> waiting;
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const Node& node = nodes_[at(waiting[--count])];
    for (unsigned left = near_children(node, sphere); left != 0; left &= left - 1) {
      const std::int32_t child = node.child[static_cast<std::size_t>(__builtin_ctz(left))];
      if (child >= 0) {
        waiting[count++] = child;
      } else if (child != kNothing) {  // which is near only if the sphere is not finite
        found.push_back(~child);
      }
    }
  }
}

unsigned ObstacleTree::near_children(const Node& node, const FloatSphere& sphere) {
  const auto along = [](const auto& low, const auto& high, float c) {
    return beyond(Floats{} + c, load_floats(low.data()), load_floats(high.data()));
  };
  const Floats x = along(node.low_x, node.high_x, sphere.x), y = along(node.low_y, node.high_y, sphere.y);
  const Floats z = along(node.low_z, node.high_z, sphere.z);
  return ~float_bits((x * x + y * y) + z * z > sphere.limit) & ((1U << kFloats) - 1);
}

}  // namespace plannercheck
