#include "bodies/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bodies/triangle_order.hpp"

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

// Nodes over sorted triangles.
class NodeBuilder {
 public:
  NodeBuilder(TriangleTree& tree, const std::vector<Vec3>& points, const std::vector<MeshTriangle>& triangles,
              const std::vector<std::size_t>& cuts, bool own_axes)
      : tree_(tree), points_(points), triangles_(triangles), cut_(cuts.begin()), own_axes_(own_axes) {
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
  std::vector<std::size_t>::const_iterator cut_;  // of the next node that is no leaf, as in TriangleOrder::children
  bool own_axes_;
  std::array<std::vector<double>, 3> columns_;  // of all corners

  PointColumns corners(TriangleRange range) const {
    const std::size_t first = 3 * range.first;
    return {&columns_[0][first], &columns_[1][first], &columns_[2][first], 3 * range.size()};
  }

  // Fills in a node; the moments of its triangles.
  SurfaceMoments add(std::size_t index, TriangleRange range) {
    TriangleNode node;
    const bool is_leaf = range.size() <= kTreeWidth;
    std::array<std::size_t, kTreeWidth> sizes;
    if (is_leaf) {
      sizes.fill(1);
      node.children = static_cast<std::uint32_t>(range.size());
      node.leaf = add_leaf(range);
      node.first = static_cast<std::int32_t>(range.first);
      put_reach(node, corners(range));
    } else {
      node.children = static_cast<std::uint32_t>(*cut_++);
      for (std::size_t k = 0; k < node.children; ++k) sizes[k] = *cut_++;
      node.first = static_cast<std::int32_t>(tree_.nodes.size());
      tree_.nodes.resize(tree_.nodes.size() + node.children);
    }
    SurfaceMoments sum;
    TriangleRange part{range.first, range.first};
    for (std::size_t k = 0; k < node.children; ++k) {
      part = {part.last, part.last + sizes[k]};
      const SurfaceMoments moments = is_leaf ? of_triangle(part.first) : add(at(node.first) + k, part);
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

// The middle and units of all corners; a box around each triangle in them.
std::vector<Box> framed(TriangleTree& tree, const std::vector<Vec3>& points,
                        const std::vector<MeshTriangle>& triangles) {
  Box all;
  for (const MeshTriangle& t : triangles) {
    for (const std::int32_t corner : t) all.add(points[at(corner)]);
  }
  tree.middle = 0.5 * all.low + 0.5 * all.high;
  const double reach = larger(norm_max(all.high - tree.middle), norm_max(all.low - tree.middle));
  if (reach > 0) tree.units = std::ldexp(1.0, std::clamp(-std::ilogb(reach) - 1, -1000, 1000));
  std::vector<Box> bounds;
  bounds.reserve(triangles.size());
  for (const MeshTriangle& t : triangles) {
    Box& box = bounds.emplace_back();
    for (const std::int32_t corner : t) box.add(tree.units * (points[at(corner)] - tree.middle));
  }
  return bounds;
}

}  // namespace

TriangleTree build_triangle_tree(const std::vector<Vec3>& points, std::vector<MeshTriangle>& triangles,
                                 std::vector<std::int32_t>& source, bool own_axes) {
  TriangleTree tree;
  TriangleOrder found = order_triangles(framed(tree, points, triangles), TriangleTree::kMostLevels);
  source = std::move(found.order);
  std::vector<MeshTriangle> sorted(triangles.size());
  for (std::size_t k = 0; k < sorted.size(); ++k) sorted[k] = triangles[at(source[k])];
  triangles = std::move(sorted);
  NodeBuilder(tree, points, triangles, found.children, own_axes).build();
  return tree;
}

}  // namespace plannercheck
