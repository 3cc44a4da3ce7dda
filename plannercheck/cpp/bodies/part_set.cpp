#include "bodies/part_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

// Below this side, m, the order of the parts does not matter, and steps would not be finite.
constexpr double kLeastSide = 0x1p-900;

// Where the parts stand along each axis, in steps of the longest side of the box around them. `point`: of a part, m.
template <class Point>
PlacedParts placed_parts(std::size_t n, Point point) {
  Box box;
  for (std::size_t i = 0; i < n; ++i) box.add(point(i));
  const double longest = norm_max(box.high - box.low);
  const double steps = longest > kLeastSide ? ((1 << kPlaceBits) - 1) / longest : 0;
  PlacedParts places(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p = steps * (point(i) - box.low);
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

double PartSet::lattice(std::size_t axis, std::int64_t key) const {
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
    side[axis] = {lattice(axis, key), lattice(axis, key + leaf.size[k])};
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
