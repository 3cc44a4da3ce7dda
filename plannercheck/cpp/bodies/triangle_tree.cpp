#include "bodies/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/spatial_partition.hpp"

namespace plannercheck {
namespace {

// A leaf's reach is rounded to a float; and from the tree's units to m and back, places err by a few u of their size,
// which is at most 1.
constexpr double kReachRoundedUp = 1 + 0x1p-20, kReachRoom = 0x1p-40;

// Triangles from the first up to the last, the last one excluded, in the tree's order.
struct TriangleRange {
  std::size_t first, last;

  std::size_t size() const { return last - first; }
};

// Sorts triangles so that the eighths of a range are neighbours, and so on in each of them.
class TriangleOrder {
 public:
  explicit TriangleOrder(const std::vector<Vec3>& centres) : centres_(centres), order_(indices_below(centres.size())) {
    sort({order_.data(), order_.data() + order_.size()});
  }

  std::vector<std::int32_t> take() { return std::move(order_); }

  // Triangles that each child of a range's node has; the last one may have fewer.
  static std::size_t below_child(std::size_t count) {
    std::size_t capacity = 1;
    while (capacity * kTreeWidth < count) capacity *= kTreeWidth;
    return capacity;
  }

 private:
  const std::vector<Vec3>& centres_;
  std::vector<std::int32_t> order_;

  void sort(IndexRange range) {
    const std::size_t capacity = below_child(static_cast<std::size_t>(range.size()));
    const auto parts = spatial_partition(centres_, range, static_cast<std::ptrdiff_t>(capacity));
    for (const IndexRange& part : parts) {
      if (part.size() > 1) sort(part);
    }
  }
};

// Nodes over sorted triangles.
class NodeBuilder {
 public:
  NodeBuilder(TriangleTree& tree, const std::vector<Vec3>& points, const std::vector<MeshTriangle>& triangles,
              bool own_axes)
      : tree_(tree), points_(points), triangles_(triangles), own_axes_(own_axes) {
    for (std::vector<double>& column : columns_) column.reserve(3 * triangles.size());
    for (const MeshTriangle& t : triangles) {
      for (const std::int32_t corner : t) {
        const Vec3 p = tree.units * (points[at(corner)] - tree.middle);
        columns_[0].push_back(p.x), columns_[1].push_back(p.y), columns_[2].push_back(p.z);
      }
    }
  }

  void build() {
    const TriangleRange all{0, triangles_.size()};
    tree_.nodes.emplace_back();
    tree_.root = fit(all, add(0, all)).box;
  }

 private:
  TriangleTree& tree_;
  const std::vector<Vec3>& points_;
  const std::vector<MeshTriangle>& triangles_;
  bool own_axes_;
  std::array<std::vector<double>, 3> columns_;  // of all corners

  PointColumns corners(TriangleRange range) const {
    const std::size_t first = 3 * range.first;
    return {&columns_[0][first], &columns_[1][first], &columns_[2][first], 3 * range.size()};
  }

  // Fills in a node; the moments of its triangles.
  SurfaceMoments add(std::size_t index, TriangleRange range) {
    const std::size_t capacity = TriangleOrder::below_child(range.size());
    TriangleNode node;
    node.children = static_cast<std::uint32_t>((range.size() + capacity - 1) / capacity);
    if (capacity == 1) {
      node.leaf = add_leaf(range);
      node.first = static_cast<std::int32_t>(range.first);
      put_reach(node, corners(range));
    } else {
      node.first = static_cast<std::int32_t>(tree_.nodes.size());
      tree_.nodes.resize(tree_.nodes.size() + node.children);
    }
    SurfaceMoments sum;
    for (std::size_t k = 0; k < node.children; ++k) {
      const std::size_t first = range.first + k * capacity;
      const TriangleRange part{first, std::min(first + capacity, range.last)};
      const SurfaceMoments moments = capacity == 1 ? of_triangle(first) : add(at(node.first) + k, part);
      put(node, k, fit(part, moments));
      sum.add(moments);
    }
    tree_.nodes[index] = node;
    return sum;
  }

  FittedBox fit(TriangleRange range, const SurfaceMoments& moments) const {
    const PointColumns points = corners(range);
    if (!own_axes_) return box_along_frame(points);
    return range.size() == 1 ? fitted_box_of_triangle(points) : fitted_box(points, moments);
  }

  SurfaceMoments of_triangle(std::size_t k) const {
    const auto corner = [&](std::size_t i) {
      return Vec3{columns_[0][3 * k + i], columns_[1][3 * k + i], columns_[2][3 * k + i]};
    };
    return moments_of(corner(0), corner(1), corner(2));
  }

  static void put(TriangleNode& node, std::size_t k, const FittedBox& fitted) {
    for (std::size_t i = 0; i < 3; ++i) {
      node.centre[i][k] = fitted.box.centre[i], node.half[i][k] = fitted.box.half[i];
      for (std::size_t j = 0; j < 2; ++j) node.axis[j][i][k] = fitted.axes[j][i];
    }
  }

  static void put_reach(TriangleNode& node, const PointColumns& points) {
    double reach = 0;
    const std::array<const double*, 3> columns{points.x, points.y, points.z};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax_element(columns[i], columns[i] + points.count);
      node.middle[i] = static_cast<float>(0.5 * *low + 0.5 * *high);
      const auto middle = static_cast<double>(node.middle[i]);
      reach = larger(reach, larger(*high - middle, middle - *low));
    }
    node.reach = static_cast<float>(reach * kReachRoundedUp + kReachRoom);
  }

  std::int32_t add_leaf(TriangleRange range) {
    EightTriangles leaf;
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      const MeshTriangle& t = triangles_[range.first + std::min(k, range.size() - 1)];
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 p = points_[at(t[i])];
        leaf.place[i][0][k] = p.x, leaf.place[i][1][k] = p.y, leaf.place[i][2][k] = p.z;
      }
    }
    tree_.leaves.push_back(leaf);
    return static_cast<std::int32_t>(tree_.leaves.size()) - 1;
  }
};

// The middle and units of all corners, and twice the middle of each triangle's own extent.
std::vector<Vec3> framed(TriangleTree& tree, const std::vector<Vec3>& points,
                         const std::vector<MeshTriangle>& triangles) {
  const auto least = [](Vec3 a, Vec3 b) { return Vec3{smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z)}; };
  const auto most = [](Vec3 a, Vec3 b) { return Vec3{larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)}; };
  Vec3 low = points[at(triangles.front()[0])], high = low;
  for (const MeshTriangle& t : triangles) {
    for (const std::int32_t corner : t) low = least(low, points[at(corner)]), high = most(high, points[at(corner)]);
  }
  tree.middle = 0.5 * low + 0.5 * high;
  const double reach = larger(norm_max(high - tree.middle), norm_max(low - tree.middle));
  if (reach > 0) tree.units = std::ldexp(1.0, std::clamp(-std::ilogb(reach) - 1, -1000, 1000));
  std::vector<Vec3> centres;
  centres.reserve(triangles.size());
  for (const MeshTriangle& t : triangles) {
    const auto corner = [&](std::size_t k) { return tree.units * (points[at(t[k])] - tree.middle); };
    const Vec3 a = corner(0), b = corner(1), c = corner(2);
    centres.push_back(least(a, least(b, c)) + most(a, most(b, c)));
  }
  return centres;
}

}  // namespace

TriangleTree build_triangle_tree(const std::vector<Vec3>& points, std::vector<MeshTriangle>& triangles,
                                 std::vector<std::int32_t>& source, bool own_axes) {
  TriangleTree tree;
  source = TriangleOrder(framed(tree, points, triangles)).take();
  std::vector<MeshTriangle> sorted(triangles.size());
  for (std::size_t k = 0; k < sorted.size(); ++k) sorted[k] = triangles[at(source[k])];
  triangles = std::move(sorted);
  NodeBuilder(tree, points, triangles, own_axes).build();
  return tree;
}

}  // namespace plannercheck
