// Triangles in the order of a tree's leaves, cut so that few boxes of two trees meet.
//
// In: boxes around triangles. Out: an order, and how its nodes are cut. Idea: a cut across an axis minimises the sum
// over both sides of surface times number of leaves (the surface area heuristic of Goldsmith and Salmon, 1987); the
// part with the largest surface is cut again, until there are as many as a node has children (Wald, Benthin and Boulos,
// 2008). Cuts are at whole leaves, so that all leaves but the last one are full. If such cuts would make the tree too
// deep, a node is cut evenly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/box.hpp"

namespace plannercheck {

struct TriangleOrder {
  std::vector<std::int32_t> order;
  // For each node with more triangles than a leaf holds: how many children it has, then how many triangles each child
  // has. A node comes before all nodes below it, and these before the node's next neighbour.
  std::vector<std::size_t> children;
};

// `levels`: how deep the tree may be, leaves counted, which are enough for so many triangles.
TriangleOrder order_triangles(const std::vector<Box>& bounds, std::size_t levels);

}  // namespace plannercheck
