#include "bodies/part_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Coordinates in the tree's units err by less than half of this: a difference is rounded, a power of two is exact.
constexpr double kPartUnitsError = 0x1p-50;

// The sides around all parts are rounded outwards by this part of the largest ones: they err where radii are added, and
// where this is.
constexpr double kSideError = 0x1p-51;

// More than 1 by twice what a float may be off by.
constexpr double kFloatsUp = 1 + 0x1p-23;

constexpr std::size_t kNodeGroups = kChildren / kLanes;

// Below this side, m, the order of the parts does not matter, and steps would not be finite.
constexpr double kLeastSide = 0x1p-900;

// What is not below values once it is rounded to floats, none of which is denormal.
Lanes float_not_below(Lanes values) { return values * kFloatsUp; }

// Where the parts stand along each axis, in steps of the longest side of the box around them. `point`: of a part, m.
template <class Point>
PlacedParts placed_parts(std::size_t n, Point point) {
  Vec3 low{kInfinite, kInfinite, kInfinite}, high = -low;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p = point(i);
    low = {smaller(low.x, p.x), smaller(low.y, p.y), smaller(low.z, p.z)};
    high = {larger(high.x, p.x), larger(high.y, p.y), larger(high.z, p.z)};
  }
  const double longest = norm_max(high - low);
  const double steps = longest > kLeastSide ? ((1 << kPlaceBits) - 1) / longest : 0;
  PlacedParts places(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p = steps * (point(i) - low);
    places[i] = {{static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y), static_cast<std::int32_t>(p.z)},
                 static_cast<std::int32_t>(i)};
  }
  return places;
}

std::size_t leaves_for(std::size_t parts) { return (parts + kPartsInLeaf - 1) / kPartsInLeaf; }

void check_count(std::size_t n) {
  if (n > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) - kPartsInLeaf)
    throw PartSetError("there are more parts than 2^31");
}

}  // namespace

PartSet::Extent PartSet::Extent::nothing() {
  return {{kInfinite, kInfinite, kInfinite}, {-kInfinite, -kInfinite, -kInfinite}};
}

void PartSet::Extent::take(const Extent& other) {
  low = {smaller(low.x, other.low.x), smaller(low.y, other.low.y), smaller(low.z, other.low.z)};
  high = {larger(high.x, other.high.x), larger(high.y, other.high.y), larger(high.z, other.high.z)};
}

PartSet PartSet::balls(const double* points, std::size_t n, const double* radii, bool one_radius) {
  check_count(n);
  PartSet set;
  set.kind_ = Kind::kBalls;
  set.parts_ = n, set.leaves_ = leaves_for(n);
  set.source_ = tree_order(
      placed_parts(n, [&](std::size_t i) { return Vec3{points[3 * i], points[3 * i + 1], points[3 * i + 2]}; }));
  set.points_.resize(set.leaves_);
  for (std::size_t place = 0; place < set.leaves_ * kPartsInLeaf; ++place) {
    const std::size_t from = 3 * at(set.source_[std::min(place, n - 1)]);
    EightPoints& leaf = set.points_[place / kPartsInLeaf];
    const std::size_t k = place % kPartsInLeaf;
    leaf.x[k] = points[from], leaf.y[k] = points[from + 1], leaf.z[k] = points[from + 2];
  }
  set.radii_.assign(1, radii[0]);
  set.largest_radius_ = radii[0];
  if (!one_radius) {
    set.radii_.resize(set.leaves_ * kPartsInLeaf);
    for (std::size_t place = 0; place < set.radii_.size(); ++place) {
      set.radii_[place] = radii[at(set.source_[std::min(place, n - 1)])];
      set.largest_radius_ = larger(set.largest_radius_, set.radii_[place]);
    }
  }
  set.build_levels();
  return set;
}

PartSet PartSet::cells(const std::int32_t* keys, const std::int32_t* sizes, std::size_t n, double resolution,
                       Vec3 origin) {
  check_count(n);
  PartSet set;
  set.kind_ = Kind::kCells;
  set.parts_ = n, set.leaves_ = leaves_for(n);
  set.resolution_ = resolution, set.origin_ = origin;
  set.radii_.assign(1, 0.0);
  set.source_ = tree_order(placed_parts(n, [&](std::size_t i) {
    const double half = 0.5 * static_cast<double>(sizes[i]);
    const auto middle = [&](std::size_t axis) { return static_cast<double>(keys[3 * i + axis]) + half; };
    return Vec3{middle(0), middle(1), middle(2)};
  }));
  set.cells_.resize(set.leaves_);
  for (std::size_t place = 0; place < n; ++place) {
    const std::size_t from = at(set.source_[place]), k = place % kPartsInLeaf;
    EightCells& leaf = set.cells_[place / kPartsInLeaf];
    for (std::size_t axis = 0; axis < 3; ++axis) leaf.key[axis][k] = keys[3 * from + axis];
    leaf.size[k] = sizes[from];
  }
  set.build_levels();
  return set;
}

// A leaf is a tile of 2 by 2 cells, two prisms each.
PartSet PartSet::columns(const double* heights, std::size_t rows, std::size_t columns, std::array<double, 2> step,
                         std::array<double, 2> origin, double base) {
  if (rows < 2 || columns < 2) throw PartSetError("heights need at least two rows and two columns");
  PartSet set;
  set.kind_ = Kind::kColumns;
  set.heights_.assign(heights, heights + rows * columns);
  set.rows_ = rows, set.columns_ = columns, set.step_ = step, set.base_ = base;
  set.origin_ = {origin[0], origin[1], 0};
  set.radii_.assign(1, 0.0);
  const std::size_t tiles_x = rows / 2, tiles_y = columns / 2;  // of cells there are one fewer than of vertices
  check_count(tiles_x * tiles_y);
  set.source_ = tile_order(tiles_x, tiles_y);
  set.leaves_ = set.source_.size();
  for (std::size_t leaf = 0; leaf < set.leaves_; ++leaf) {
    const EightExtents prisms = set.prism_extents(leaf);
    for (std::size_t k = 0; k < kPartsInLeaf; ++k) set.parts_ += prisms.low[0][k] <= prisms.high[0][k] ? 1 : 0;
  }
  set.build_levels();
  return set;
}

double PartSet::lattice(int axis, std::int64_t key) const {
  return origin_[axis] + static_cast<double>(key) * resolution_;
}

PartShape PartSet::shape(std::size_t place) const {
  switch (kind_) {
    case Kind::kBalls:
      return ball(place);
    case Kind::kCells:
      return cell(place);
    default:
      return prism(place);
  }
}

PartShape PartSet::ball(std::size_t place) const {
  PartShape part;
  if (place >= parts_) return part;
  const EightPoints& leaf = points_[place / kPartsInLeaf];
  const std::size_t k = place % kPartsInLeaf;
  part.corner[0] = {leaf.x[k], leaf.y[k], leaf.z[k]};
  part.corners = 1, part.radius = radius(place);
  return part;
}

PartShape PartSet::cell(std::size_t place) const {
  PartShape part;
  const EightCells& leaf = cells_[place / kPartsInLeaf];
  const std::size_t k = place % kPartsInLeaf;
  if (leaf.size[k] == 0) return part;
  std::array<std::array<double, 2>, 3> side;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t key = leaf.key[axis][k];
    side[axis] = {lattice(static_cast<int>(axis), key), lattice(static_cast<int>(axis), key + leaf.size[k])};
  }
  part.corners = 8;
  for (std::size_t c = 0; c < 8; ++c) part.corner[c] = {side[0][c & 1], side[1][c >> 1 & 1], side[2][c >> 2]};
  return part;
}

std::array<std::size_t, 2> PartSet::tile_of(std::size_t leaf) const {
  const std::size_t tiles_y = columns_ / 2, tile = at(source_[leaf]);
  return {2 * (tile / tiles_y), 2 * (tile % tiles_y)};
}

double PartSet::height_x(std::size_t i) const { return origin_.x + static_cast<double>(i) * step_[0]; }
double PartSet::height_y(std::size_t j) const { return origin_.y + static_cast<double>(j) * step_[1]; }

Vec3 PartSet::height_point(std::size_t i, std::size_t j) const {
  return {height_x(i), height_y(j), heights_[i * columns_ + j]};
}

PartShape PartSet::prism(std::size_t place) const {
  PartShape part;
  const auto [tile_i, tile_j] = tile_of(place / kPartsInLeaf);
  const std::size_t k = place % kPartsInLeaf, i = tile_i + (k >> 2), j = tile_j + (k >> 1 & 1);
  if (i + 1 >= rows_ || j + 1 >= columns_) return part;
  const Vec3 third = (k & 1) == 0 ? height_point(i + 1, j) : height_point(i, j + 1);
  const std::array<Vec3, 3> top{height_point(i, j), third, height_point(i + 1, j + 1)};
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::isnan(top[c].z)) return part;
    part.corner[c] = top[c];
    part.corner[c + 3] = {top[c].x, top[c].y, base_};
  }
  part.corners = 6;
  return part;
}

std::int64_t PartSet::source(std::size_t place) const {
  if (kind_ != Kind::kColumns) return source_[place];
  const auto [tile_i, tile_j] = tile_of(place / kPartsInLeaf);
  const std::size_t k = place % kPartsInLeaf, i = tile_i + (k >> 2), j = tile_j + (k >> 1 & 1);
  return static_cast<std::int64_t>(2 * (i * (columns_ - 1) + j) + (k & 1));
}

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
  for (std::size_t k = parts_ - std::min(parts_, first); k < kPartsInLeaf; ++k) out.put(k, Extent::nothing());
  return out;
}

PartSet::EightExtents PartSet::cell_extents(std::size_t leaf) const {
  const EightCells& cells = cells_[leaf];
  EightExtents out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double origin = origin_[static_cast<int>(axis)];
    for (std::size_t k = 0; k < kPartsInLeaf; ++k) {
      const double key = cells.key[axis][k], size = cells.size[k];
      out.low[axis][k] = size > 0 ? origin + key * resolution_ : kInfinite;
      out.high[axis][k] = size > 0 ? origin + (key + size) * resolution_ : -kInfinite;
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
  for (auto& along : low) along.fill(kInfinite);
  for (auto& along : high) along.fill(-kInfinite);
}

void PartSet::EightExtents::put(std::size_t k, const Extent& extent) {
  low[0][k] = extent.low.x, low[1][k] = extent.low.y, low[2][k] = extent.low.z;
  high[0][k] = extent.high.x, high[1][k] = extent.high.y, high[2][k] = extent.high.z;
}

PartSet::Extent PartSet::EightExtents::around() const {
  Extent all = Extent::nothing();
  for (std::size_t k = 0; k < kChildren; ++k) {
    all.take({{low[0][k], low[1][k], low[2][k]}, {high[0][k], high[1][k], high[2][k]}});
  }
  return all;
}

// The extents are rounded to nearest where radii are added, by 2^-53 of how far they are from the origin. That is not
// counted here: whoever looks at boxes has room for far more, 1e-5 (PartWalk) or 2^-42 (the slack of motions) of it.
PartNode PartSet::boxes(const EightExtents& extents) const {
  PartNode node;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double middle = middle_[static_cast<int>(axis)];
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
      halves[g] = low <= high ? half : broadcast(-kInfinite);
    }
    store_floats(node.half[axis].data(), joined_floats(halves.data(), 1));
  }
  return node;
}

PartNode PartSet::leaf_boxes(std::size_t leaf) const { return boxes(part_extents(leaf)); }

void PartSet::frame_units(const Extent& all) {
  middle_ = 0.5 * (all.low + all.high);
  const double half = larger(norm_max(all.high - middle_), norm_max(middle_ - all.low));
  // Beyond these, floats could not hold places in units.
  units_ = half > 0x1p-900 ? std::ldexp(1, -std::ilogb(half) - 1) : 1;
  const double outwards = (norm_max(all.low) + norm_max(all.high)) * kSideError;
  low_ = all.low - Vec3{outwards, outwards, outwards}, high_ = all.high + Vec3{outwards, outwards, outwards};
}

void PartSet::build_levels() {
  const auto parents = [](std::size_t n) { return std::max<std::size_t>(1, (n + kChildren - 1) / kChildren); };
  Array<EightExtents> extents(parents(leaves_));
  Extent all = Extent::nothing();
  for (std::size_t leaf = 0; leaf < leaves_; ++leaf) {
    const Extent around = part_extents(leaf).around();
    extents[leaf / kChildren].put(leaf % kChildren, around);
    all.take(around);
  }
  frame_units(parts_ == 0 ? Extent{} : all);
  for (;;) {
    Array<PartNode> nodes(extents.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = boxes(extents[i]);
    levels_.push_back(std::move(nodes));
    if (extents.size() == 1) return;
    Array<EightExtents> above(parents(extents.size()));
    for (std::size_t i = 0; i < extents.size(); ++i) above[i / kChildren].put(i % kChildren, extents[i].around());
    extents = std::move(above);
  }
}

Vec3 PartSet::reach() const {
  return {larger(std::fabs(low_.x), std::fabs(high_.x)), larger(std::fabs(low_.y), std::fabs(high_.y)),
          larger(std::fabs(low_.z), std::fabs(high_.z))};
}

PartSet::Given PartSet::given() const {
  Given out;
  out.resolution = resolution_, out.origin = origin_, out.step = step_, out.base = base_;
  out.rows = rows_, out.columns = columns_;
  if (kind_ == Kind::kColumns) {
    out.numbers.assign(heights_.begin(), heights_.end());
    return out;
  }
  const bool are_balls = kind_ == Kind::kBalls, one_radius = radii_.size() == 1;
  out.radii.assign(one_radius ? 1 : parts_, largest_radius_);
  (are_balls ? out.numbers : out.radii).resize(are_balls ? 3 * parts_ : 1);
  if (!are_balls) out.keys.resize(3 * parts_), out.sizes.resize(parts_);
  for (std::size_t place = 0; place < parts_; ++place) {
    const std::size_t to = at(source_[place]), leaf = place / kPartsInLeaf, k = place % kPartsInLeaf;
    if (!are_balls) {
      for (std::size_t axis = 0; axis < 3; ++axis) out.keys[3 * to + axis] = cells_[leaf].key[axis][k];
      out.sizes[to] = cells_[leaf].size[k];
      continue;
    }
    const EightPoints& points = points_[leaf];
    out.numbers[3 * to] = points.x[k], out.numbers[3 * to + 1] = points.y[k], out.numbers[3 * to + 2] = points.z[k];
    if (!one_radius) out.radii[to] = radii_[place];
  }
  return out;
}

std::size_t PartSet::bytes() const {
  const auto size = [](const auto& v) { return v.size() * sizeof(v[0]); };
  std::size_t sum = size(source_) + size(points_) + size(radii_) + size(cells_) + size(heights_);
  for (const auto& level : levels_) sum += size(level);
  return sum;
}

}  // namespace plannercheck
