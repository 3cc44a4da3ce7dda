#include "bodies/triangle_tree.hpp"

#include <algorithm>
#include <cmath>

#include "math/spatial_partition.hpp"

namespace plannercheck {
namespace {

// Coordinates in the tree's units err by half of this: a difference is rounded, a power of two is exact.
constexpr double kUnitsError = 0x1p-50;

float float_above(double value) {
  const auto rounded = static_cast<float>(value);
  return static_cast<double>(rounded) < value ? std::nextafterf(rounded, std::numeric_limits<float>::infinity())
                                              : rounded;
}

struct Extent {
  Vec3 low, high;

  void take(Vec3 p) {
    low = {smaller(low.x, p.x), smaller(low.y, p.y), smaller(low.z, p.z)};
    high = {larger(high.x, p.x), larger(high.y, p.y), larger(high.z, p.z)};
  }
};

FloatBox float_box(const Extent& extent) {
  FloatBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int i = static_cast<int>(axis);
    const double low = extent.low[i] - kUnitsError, high = extent.high[i] + kUnitsError;
    box.centre[axis] = static_cast<float>(0.5 * (low + high));
    const auto centre = static_cast<double>(box.centre[axis]);
    // Of two floats and of numbers up to 1, differences in doubles err by 2^-53 at most.
    box.half[axis] = float_above(larger(high - centre, centre - low) + kUnitsError);
  }
  return box;
}

class TreeBuilder {
 public:
  TreeBuilder(TriangleTree& tree, const std::vector<Vec3>& points, const std::vector<MeshTriangle>& triangles)
      : tree_(tree), points_(points), triangles_(triangles) {
    for (const MeshTriangle& t : triangles) {
      const Vec3 a = in_units(points[at(t[0])]);
      Extent extent{a, a};
      extent.take(in_units(points[at(t[1])]));
      extent.take(in_units(points[at(t[2])]));
      extents_.push_back(extent);
      centres_.push_back(extent.low + extent.high);
    }
  }

  // The triangles' order in the tree.
  std::vector<std::int32_t> build() {
    order_ = indices_below(extents_.size());
    const IndexRange all{order_.data(), order_.data() + order_.size()};
    tree_.root = float_box(around(all));
    add(all);
    return std::move(order_);
  }

 private:
  TriangleTree& tree_;
  const std::vector<Vec3>& points_;
  const std::vector<MeshTriangle>& triangles_;
  std::vector<Extent> extents_;
  std::vector<Vec3> centres_;
  std::vector<std::int32_t> order_;

  Vec3 in_units(Vec3 p) const { return tree_.units * (p - tree_.middle); }

  Extent around(IndexRange range) const {
    Extent out = extents_[at(*range.first)];
    for (const std::int32_t* i = range.first; i != range.last; ++i) {
      out.take(extents_[at(*i)].low);
      out.take(extents_[at(*i)].high);
    }
    return out;
  }

  std::int32_t add(IndexRange range) {
    std::ptrdiff_t capacity = 1;
    while (capacity * static_cast<std::ptrdiff_t>(kTreeWidth) < range.size()) {
      capacity *= static_cast<std::ptrdiff_t>(kTreeWidth);
    }
    const std::vector<IndexRange> parts = spatial_partition(centres_, range, capacity);
    const std::size_t index = tree_.nodes.size();
    tree_.nodes.emplace_back();  // before its children
    TriangleNode node;
    if (capacity == 1) node.leaf = add_leaf(range);
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      const bool is_empty = k >= parts.size();
      constexpr float kEmpty = -std::numeric_limits<float>::infinity();
      const FloatBox box = is_empty ? FloatBox{{}, {kEmpty, kEmpty, kEmpty}} : float_box(around(parts[k]));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        node.centre[axis][k] = box.centre[axis], node.half[axis][k] = box.half[axis];
      }
      node.child[k] = is_empty        ? TriangleTree::kNothing
                      : capacity == 1 ? ~static_cast<std::int32_t>(parts[k].first - order_.data())
                                      : add(parts[k]);
    }
    tree_.nodes[index] = node;
    return static_cast<std::int32_t>(index);
  }

  // The triangles of a range are in its order, as parts of one triangle are.
  std::int32_t add_leaf(IndexRange range) {
    EightTriangles leaf;
    leaf.count = static_cast<std::size_t>(range.size());
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      const MeshTriangle& t = triangles_[at(range.first[std::min(k, leaf.count - 1)])];
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 p = points_[at(t[i])];
        leaf.corner[i][0][k] = p.x, leaf.corner[i][1][k] = p.y, leaf.corner[i][2][k] = p.z;
      }
    }
    tree_.leaves.push_back(leaf);
    return static_cast<std::int32_t>(tree_.leaves.size()) - 1;
  }
};

}  // namespace

TriangleTree build_triangle_tree(const std::vector<Vec3>& points, std::vector<MeshTriangle>& triangles,
                                 std::vector<std::int32_t>& source) {
  const Vec3 first = points[at(triangles.front()[0])];
  Extent all{first, first};
  for (const MeshTriangle& t : triangles) {
    for (const std::int32_t corner : t) all.take(points[at(corner)]);
  }
  TriangleTree tree;
  tree.middle = 0.5 * all.low + 0.5 * all.high;
  const double reach = larger(norm_max(all.high - tree.middle), norm_max(all.low - tree.middle));
  if (reach > 0) tree.units = std::ldexp(1.0, std::clamp(-std::ilogb(reach) - 1, -1000, 1000));
  source = TreeBuilder(tree, points, triangles).build();
  std::vector<MeshTriangle> sorted(triangles.size());
  for (std::size_t k = 0; k < sorted.size(); ++k) sorted[k] = triangles[at(source[k])];
  triangles = std::move(sorted);
  return tree;
}

}  // namespace plannercheck
