// The boxes of a set's parts, of its leaves, and of the nodes of its tree.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bodies/part_set.hpp"
#include "math/simd.hpp"

namespace plannercheck {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// Coordinates in the tree's units err by less than half of this: a difference is rounded, a power of two is exact.
constexpr double kPartUnitsError = 0x1p-50;

// The sides around all parts are rounded outwards by this part of the largest ones: they err where radii are added, and
// where this is.
constexpr double kSideError = 0x1p-51;

// More than 1 by twice what a float may be off by.
constexpr double kFloatsUp = 1 + 0x1p-23;

constexpr std::size_t kNodeGroups = kChildren / kLanes;

// What is not below values once it is rounded to floats, none of which is denormal.
Lanes float_not_below(Lanes values) { return values * kFloatsUp; }

}  // namespace

PartSet::EightExtents PartSet::part_extents(std::size_t leaf) const {
  switch (kind_) {
    case Kind::kBalls:
      return ball_extents(leaf);
    case Kind::kCells:
      return cell_extents(leaf);
    default:
      return prism_extents(leaf);
  }
}

PartSet::EightExtents PartSet::ball_extents(std::size_t leaf) const {
  const EightPoints& points = points_[leaf];
  EightExtents out;
  for (std::size_t k = 0; k < kPartsInLeaf; ++k) {
    const double r = radius(kPartsInLeaf * leaf + k);
    out.low[0][k] = points.x[k] - r, out.high[0][k] = points.x[k] + r;
    out.low[1][k] = points.y[k] - r, out.high[1][k] = points.y[k] + r;
    out.low[2][k] = points.z[k] - r, out.high[2][k] = points.z[k] + r;
  }
  const std::size_t first = kPartsInLeaf * leaf;
  for (std::size_t k = parts_ - std::min(parts_, first); k < kPartsInLeaf; ++k) out.put(k, {});
  return out;
}

PartSet::EightExtents PartSet::cell_extents(std::size_t leaf) const {
  const EightCells& cells = cells_[leaf];
  EightExtents out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double origin = origin_[axis];
    for (std::size_t k = 0; k < kPartsInLeaf; ++k) {
      const double key = cells.key[axis][k], size = cells.size[k];
      out.low[axis][k] = size > 0 ? origin + key * resolution_ : kUnbounded;
      out.high[axis][k] = size > 0 ? origin + (key + size) * resolution_ : -kUnbounded;
    }
  }
  return out;
}

// The prisms of a cell are as wide as the cell.
PartSet::EightExtents PartSet::prism_extents(std::size_t leaf) const {
  const auto [first_i, first_j] = tile_of(leaf);
  std::array<std::array<double, 3>, 3> height;
  std::array<double, 3> x, y;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const bool there = first_i + i < rows_ && first_j + j < columns_;
      height[i][j] =
          there ? heights_[(first_i + i) * columns_ + first_j + j] : std::numeric_limits<double>::quiet_NaN();
    }
    x[i] = height_x(first_i + i), y[i] = height_y(first_j + i);
  }
  EightExtents out;
  for (std::size_t k = 0; k < kPartsInLeaf; ++k) {
    const std::size_t i = k >> 2, j = k >> 1 & 1;
    const double a = height[i][j], b = (k & 1) == 0 ? height[i + 1][j] : height[i][j + 1], c = height[i + 1][j + 1];
    if (std::isnan(a + b + c)) continue;
    out.put(k, {{smaller(x[i], x[i + 1]), smaller(y[j], y[j + 1]), smaller(smaller(base_, a), smaller(b, c))},
                {larger(x[i], x[i + 1]), larger(y[j], y[j + 1]), larger(larger(base_, a), larger(b, c))}});
  }
  return out;
}

PartSet::EightExtents::EightExtents() {
  for (auto& along : low) along.fill(kUnbounded);
  for (auto& along : high) along.fill(-kUnbounded);
}

void PartSet::EightExtents::put(std::size_t k, const Box& extent) {
  low[0][k] = extent.low.x, low[1][k] = extent.low.y, low[2][k] = extent.low.z;
  high[0][k] = extent.high.x, high[1][k] = extent.high.y, high[2][k] = extent.high.z;
}

Box PartSet::EightExtents::around() const {
  Box all;
  for (std::size_t k = 0; k < kChildren; ++k) {
    all.add(Box{{low[0][k], low[1][k], low[2][k]}, {high[0][k], high[1][k], high[2][k]}});
  }
  return all;
}

// The extents are rounded to nearest where radii are added, by 2^-53 of how far they are from the origin. That is not
// counted here: whoever looks at boxes has room for far more, 1e-5 (PartWalk) or 2^-42 (the slack of motions) of it.
PartNode PartSet::boxes(const EightExtents& extents) const {
  PartNode node;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = middle_[axis];
    std::array<Lanes, kNodeGroups> lows, highs, centres, halves;
    for (std::size_t g = 0; g < kNodeGroups; ++g) {
      lows[g] = (load_lanes(&extents.low[axis][g * kLanes]) - middle) * units_ - kPartUnitsError;
      highs[g] = (load_lanes(&extents.high[axis][g * kLanes]) - middle) * units_ + kPartUnitsError;
      centres[g] = lows[g] <= highs[g] ? 0.5 * (lows[g] + highs[g]) : Lanes{};
    }
    store_floats(node.centre[axis].data(), joined_floats(centres.data(), 1));
    for (std::size_t g = 0; g < kNodeGroups; ++g) {
      const Lanes low = lows[g], high = highs[g], centre = load_widened(&node.centre[axis][g * kLanes]);
      const Lanes half = float_not_below(larger(high - centre, centre - low) + kPartUnitsError);
      halves[g] = low <= high ? half : broadcast(-kUnbounded);
    }
    store_floats(node.half[axis].data(), joined_floats(halves.data(), 1));
  }
  return node;
}

PartNode PartSet::leaf_boxes(std::size_t leaf) const { return boxes(part_extents(leaf)); }

void PartSet::frame_units(const Box& all) {
  middle_ = 0.5 * (all.low + all.high);
  const double half = larger(norm_max(all.high - middle_), norm_max(middle_ - all.low));
  // Beyond these, floats could not hold places in units.
  units_ = half > 0x1p-900 ? std::ldexp(1, -std::ilogb(half) - 1) : 1;
  const double outwards = (norm_max(all.low) + norm_max(all.high)) * kSideError;
  box_ = all.grown(outwards);
}

void PartSet::build_levels() {
  const auto parents = [](std::size_t n) { return std::max<std::size_t>(1, (n + kChildren - 1) / kChildren); };
  std::vector<EightExtents> extents(parents(leaves_));
  Box all;
  for (std::size_t leaf = 0; leaf < leaves_; ++leaf) {
    const Box around = part_extents(leaf).around();
    extents[leaf / kChildren].put(leaf % kChildren, around);
    all.add(around);
  }
  frame_units(parts_ == 0 ? Box{{}, {}} : all);
  for (;;) {
    std::vector<PartNode> nodes(extents.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = boxes(extents[i]);
    levels_.push_back(std::move(nodes));
    if (extents.size() == 1) return;
    std::vector<EightExtents> above(parents(extents.size()));
    for (std::size_t i = 0; i < extents.size(); ++i) above[i / kChildren].put(i % kChildren, extents[i].around());
    extents = std::move(above);
  }
}

}  // namespace plannercheck
