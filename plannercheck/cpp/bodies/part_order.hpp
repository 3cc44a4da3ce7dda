// The order in which parts stand in the tree of a set, so that neighbours in it are near each other.
//
// In: places of parts, or how many tiles there are. Out: indices in the order. A node's children are split in halves
// along the longest side of the box around their places; tiles are ordered along Morton's curve (Morton 1966).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plannercheck {

inline constexpr std::size_t kPartsInLeaf = 8, kChildren = 8;

// Bits of a place along an axis.
inline constexpr int kPlaceBits = 24;

// A part's place on its way into the order, each coordinate of at least 0: 16 bytes.
struct PlacedPart {
  std::array<std::int32_t, 3> at;
  std::int32_t index;
};

using PlacedParts = std::vector<PlacedPart>;
using PartIndices = std::vector<std::int32_t>;

// Indices of the parts in the order of a tree in which each child of a node, but the last, has as many parts below it.
PartIndices tree_order(PlacedParts parts);

// Indices i · tiles_y + j of tiles.
PartIndices tile_order(std::size_t tiles_x, std::size_t tiles_y);

}  // namespace plannercheck
