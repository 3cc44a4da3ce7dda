#include "broad_phase/obstacle_tree.hpp"

namespace plannercheck {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Box box_around(const std::vector<Box>& boxes, IndexRange range) {
  Box out;
  for (const std::int32_t* i = range.first; i != range.last; ++i) out.add(boxes[at(*i)]);
  return out;
}

}  // namespace

ObstacleTree::ObstacleTree(const std::vector<Box>& boxes) {
  std::vector<std::int32_t> order = indices_below(boxes.size());
  std::vector<Vec3> centres;
  for (const Box& box : boxes) centres.push_back(box.low + box.high);
  if (!order.empty()) build(boxes, centres, {order.data(), order.data() + order.size()});
}

std::int32_t ObstacleTree::build(const std::vector<Box>& boxes, const std::vector<Vec3>& centres, IndexRange range) {
  std::ptrdiff_t capacity = 1;
  while (capacity * kFloats < range.size()) capacity *= kFloats;
  const std::vector<IndexRange> parts = spatial_partition(centres, range, capacity);

  const std::size_t index = nodes_.size();
  nodes_.emplace_back();  // before its children
  Node node;
  for (std::size_t k = 0; k < kFloats; ++k) {
    const bool empty = k >= parts.size();
    const Box box = empty ? Box{} : box_around(boxes, parts[k]);
    node.low_x[k] = empty ? kInfinity : rounded_down(box.low.x),
    node.high_x[k] = empty ? -kInfinity : rounded_up(box.high.x);
    node.low_y[k] = empty ? kInfinity : rounded_down(box.low.y),
    node.high_y[k] = empty ? -kInfinity : rounded_up(box.high.y);
    node.low_z[k] = empty ? kInfinity : rounded_down(box.low.z),
    node.high_z[k] = empty ? -kInfinity : rounded_up(box.high.z);
    node.child[k] = empty ? kNothing : parts[k].size() == 1 ? ~*parts[k].first : build(boxes, centres, parts[k]);
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
      } else if (child != kNothing) {  // such a child is near only if the sphere is not finite
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
  return ~bits_above((x * x + y * y) + z * z, Floats{} + sphere.limit) & ((1U << kFloats) - 1);
}

}  // namespace plannercheck
