#include "broad_phase/clearance_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "broad_phase/clearances_at.hpp"
#include "math/box.hpp"

namespace plannercheck {
namespace {

// Cells at most. A step is then 2 cm before a robot of 1.4 m; each cell takes a byte, and a nanosecond to fill.
constexpr double kMostGridCells = 0x1p18;

// Shorter steps would be finer than what motions leave open anyway, m.
constexpr double kShortestStep = 0.01;

// Grids with longer steps say too little about a robot's links, m.
constexpr double kLongestStep = 0.09;

// The furthest mark that is looked for, in steps. Squares of lengths in steps then fit into a byte.
constexpr std::size_t kMostSteps = 11;
constexpr std::uint8_t kFarthestSquare = kMostSteps * kMostSteps;

// Lengths are kept in this part of a step, rounded down.
constexpr double kStepParts = 23;
static_assert(kMostSteps * kStepParts < 256);

// Bounds the rounding of points, posed and taken to cells, as a part of all numbers that enter: sums and products of
// doubles err by far less.
constexpr double kGridRounding = 0x1p-40;

// Boxes of a tree are larger than those of centres by the radius, up to the rounding of floats.
constexpr double kWithinRadius = 1 - 0x1p-20;

constexpr std::size_t kRowBytes = 32;
typedef std::uint8_t Bytes __attribute__((vector_size(kRowBytes)));

Bytes load_bytes(const std::uint8_t* from) {
  Bytes bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  return bytes;
}

Bytes fewer(Bytes a, Bytes b) { return a < b ? a : b; }

std::uint8_t square_of(std::size_t cells_away) {
  const std::size_t gap = cells_away > 0 ? cells_away - 1 : 0;
  return static_cast<std::uint8_t>(gap * gap);
}

}  // namespace

// Rows of bytes with so much room on both sides that reading next to a row needs no care.
class ByteRows {
 public:
  explicit ByteRows(const std::array<std::size_t, 3>& cells)
      : cells_(cells),
        stride_((cells[0] + kRowBytes - 1) / kRowBytes * kRowBytes + 2 * kRowBytes),
        bytes_(stride_ * cells[1] * cells[2], kFarthestSquare) {}

  std::uint8_t* row(std::size_t j, std::size_t k) { return &bytes_[(k * cells_[1] + j) * stride_ + kRowBytes]; }
  const std::uint8_t* row(std::size_t j, std::size_t k) const {
    return &bytes_[(k * cells_[1] + j) * stride_ + kRowBytes];
  }

 private:
  static_assert(kMostSteps <= kRowBytes);
  std::array<std::size_t, 3> cells_;
  std::size_t stride_;
  std::vector<std::uint8_t> bytes_;
};

// Squared distances from the marked cells, computed axis by axis.
class SquaredGaps {
 public:
  SquaredGaps(const std::array<std::size_t, 3>& cells, const std::array<bool, 6>& closed)
      : cells_(cells), closed_(closed), from_(cells), to_(cells) {}

  // Marks the cells first to past − 1 of a row.
  void mark(std::size_t first, std::size_t past, std::size_t j, std::size_t k) {
    std::fill_n(from_.row(j, k) + first, past - first, std::uint8_t{0});
  }

  // Computes all squared lengths; the result holds them in rows.
  const ByteRows& spread() {
    for (std::size_t k = 0; k < cells_[2]; ++k) {
      for (std::size_t j = 0; j < cells_[1]; ++j) along_row(j, k);
    }
    for (std::size_t k = 0; k < cells_[2]; ++k) {
      for (std::size_t j = 0; j < cells_[1]; ++j) {
        across(1, j, to_.row(j, k), from_.row(j, k), [&](std::size_t other) { return to_.row(other, k); });
      }
    }
    for (std::size_t k = 0; k < cells_[2]; ++k) {
      for (std::size_t j = 0; j < cells_[1]; ++j) {
        across(2, k, from_.row(j, k), to_.row(j, k), [&](std::size_t other) { return from_.row(j, other); });
      }
    }
    return to_;
  }

 private:
  std::array<std::size_t, 3> cells_;
  std::array<bool, 6> closed_;  // sides, the low ones first, beyond which parts may be
  ByteRows from_, to_;

  void along_row(std::size_t j, std::size_t k) {
    std::uint8_t* const row = from_.row(j, k);
    if (closed_[0]) row[-1] = 0;
    std::fill_n(row + cells_[0], kRowBytes, kFarthestSquare);
    if (closed_[3]) row[cells_[0]] = 0;
    std::uint8_t* const out = to_.row(j, k);
    for (std::size_t i = 0; i < cells_[0]; i += kRowBytes) {
      Bytes least = load_bytes(row + i);
      for (std::size_t away = 1; away <= kMostSteps; ++away) {
        least = fewer(least, fewer(load_bytes(row + i - away), load_bytes(row + i + away)) + square_of(away));
      }
      std::memcpy(out + i, &least, sizeof least);
    }
  }

  template <class Row>
  void across(std::size_t axis, std::size_t place, const std::uint8_t* own, std::uint8_t* out, Row row) const {
    const std::size_t count = cells_[axis];
    std::uint8_t beyond = kFarthestSquare;
    if (closed_[axis]) beyond = std::min(beyond, square_within(place + 1));
    if (closed_[axis + 3]) beyond = std::min(beyond, square_within(count - place));
    for (std::size_t i = 0; i < cells_[0]; i += kRowBytes) {
      Bytes least = fewer(load_bytes(own + i), Bytes{} + beyond);
      for (std::size_t away = 1; away <= kMostSteps; ++away) {
        if (place >= away) least = fewer(least, load_bytes(row(place - away) + i) + square_of(away));
        if (place + away < count) least = fewer(least, load_bytes(row(place + away) + i) + square_of(away));
      }
      std::memcpy(out + i, &least, sizeof least);
    }
  }

  static std::uint8_t square_within(std::size_t away) { return away <= kMostSteps ? square_of(away) : kFarthestSquare; }
};

namespace {

// Around what a box of a posed set holds.
Box world_sides(const Pose& pose, const Box& box) {
  const Vec3 middle = pose.apply(0.5 * (box.low + box.high)), half = 0.5 * (box.high - box.low);
  std::array<double, 3> out;
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = std::fabs(pose.m[4 * i]) * half.x + std::fabs(pose.m[4 * i + 1]) * half.y +
             std::fabs(pose.m[4 * i + 2]) * half.z;
  }
  const Vec3 around{out[0], out[1], out[2]};
  return {middle - around, middle + around};
}

}  // namespace

// Marks the cells that hold a set's parts, of balls their centres.
class ClearanceGrid::Marking {
 public:
  Marking(const ClearanceGrid& grid, const PartSet& parts, const Pose& pose, SquaredGaps& gaps)
      : grid_(grid),
        parts_(parts),
        pose_(pose),
        gaps_(gaps),
        least_radius_(parts_.has_one_radius() ? parts_.radius(0) * kWithinRadius : 0) {}

  void run() { open(parts_.levels().size(), 0); }

 private:
  const ClearanceGrid& grid_;
  const PartSet& parts_;
  const Pose& pose_;
  SquaredGaps& gaps_;
  double least_radius_;  // by how much boxes are larger than those of their balls' centres

  bool are_balls() const { return parts_.kind() == PartSet::Kind::kBalls; }

  void open(std::size_t level, std::size_t index) {
    if (level == 0 && are_balls()) return mark_balls(index);
    const PartNode node = level > 0 ? parts_.levels()[level - 1][index] : parts_.leaf_boxes(index);
    for (std::size_t k = 0; k < kChildren; ++k) {
      if (!(node.half[0][k] >= 0)) continue;
      const Box sides = sides_of(node, k);
      if (is_outside(sides)) continue;
      if (is_in_one_cell(sides) || (level == 0 && !are_balls())) {
        mark(sides);
      } else {
        open(level - 1, index * kChildren + k);
      }
    }
  }

  void mark_balls(std::size_t leaf) {
    const EightPoints& points = parts_.points(leaf);
    const std::size_t count = std::min(kPartsInLeaf, parts_.part_count() - leaf * kPartsInLeaf);
    for (std::size_t p = 0; p < count; ++p) {
      const Vec3 place = pose_.apply({points.x[p], points.y[p], points.z[p]});
      const std::size_t i = grid_.cell_of(0, place.x);
      gaps_.mark(i, i + 1, grid_.cell_of(1, place.y), grid_.cell_of(2, place.z));
    }
  }

  void mark(const Box& sides) {
    const std::size_t from = grid_.cell_of(0, sides.low.x), past = grid_.cell_of(0, sides.high.x) + 1;
    for (std::size_t k = grid_.cell_of(2, sides.low.z); k <= grid_.cell_of(2, sides.high.z); ++k) {
      for (std::size_t j = grid_.cell_of(1, sides.low.y); j <= grid_.cell_of(1, sides.high.y); ++j) {
        gaps_.mark(from, past, j, k);
      }
    }
  }

  Box sides_of(const PartNode& node, std::size_t child) const {
    std::array<double, 3> low, high;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto centre = static_cast<double>(node.centre[i][child]), half = static_cast<double>(node.half[i][child]);
      const double middle = parts_.middle()[i];
      const double around = larger(half / parts_.units() - least_radius_, 0);
      low[i] = middle + centre / parts_.units() - around, high[i] = middle + centre / parts_.units() + around;
    }
    return world_sides(pose_, {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}});
  }

  // Beyond a closed side; no part is beyond another one.
  bool is_outside(const Box& sides) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = grid_.low_[axis], high = low + static_cast<double>(grid_.cells_[axis]) * grid_.step_;
      if (grid_.closed_[axis] && sides.high[axis] < low) return true;
      if (grid_.closed_[axis + 3] && sides.low[axis] > high) return true;
    }
    return false;
  }

  bool is_in_one_cell(const Box& sides) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (grid_.cell_of(axis, sides.low[axis]) != grid_.cell_of(axis, sides.high[axis])) return false;
    }
    return true;
  }
};

ClearanceGrid::ClearanceGrid(const PartSet& parts, const Pose& pose, double reach) {
  const Box all = world_sides(pose, parts.box());
  std::array<double, 3> low, high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    closed_[axis] = all.low[axis]<-reach, closed_[axis + 3] = all.high[axis]> reach;
    low[axis] = std::clamp(all.low[axis], -reach, reach), high[axis] = std::clamp(all.high[axis], -reach, reach);
  }
  lay_out({low[0], low[1], low[2]}, {high[0], high[1], high[2]});
  if (step_ > kLongestStep) return;
  SquaredGaps gaps(cells_, closed_);
  Marking(*this, parts, pose, gaps).run();
  keep_lengths(gaps.spread());
  room_ = parts.largest_radius() + (norm_1(all.low) + norm_1(all.high) + norm_1(pose.translation())) * kGridRounding;
}

// The shortest steps with which there are no more cells than that.
void ClearanceGrid::lay_out(const Vec3& low, const Vec3& high) {
  constexpr double kLonger = 1.03;
  const Vec3 size = high - low;
  const auto count = [&](std::size_t axis) { return std::floor(size[axis] / step_) + 1; };
  for (step_ = kShortestStep; count(0) * count(1) * count(2) > kMostGridCells;) step_ *= kLonger;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cells_[axis] = static_cast<std::size_t>(count(axis));
    low_[axis] = low[axis], last_[axis] = count(axis) - 1;
  }
  row_ = static_cast<std::int32_t>((cells_[0] + 3) / 4), rows_ = static_cast<std::int32_t>((cells_[1] + 3) / 4);
  per_step_ = 1 / step_, unit_ = step_ / kStepParts;
}

template <class Rows>
void ClearanceGrid::keep_lengths(const Rows& squares) {
  std::array<std::uint8_t, kFarthestSquare + 1> lengths;
  for (std::size_t v = 0; v < lengths.size(); ++v) {
    lengths[v] = static_cast<std::uint8_t>(std::sqrt(static_cast<double>(v)) * kStepParts);
  }
  values_.resize(at(row_) * at(rows_) * ((cells_[2] + 3) / 4) * 64 + kGatheredBeyond);
  for (std::size_t k = 0; k < cells_[2]; ++k) {
    for (std::size_t j = 0; j < cells_[1]; ++j) {
      const std::uint8_t* const row = squares.row(j, k);
      std::uint8_t* const out = &values_[((k / 4 * at(rows_) + j / 4) * at(row_)) * 64 + k % 4 * 16 + j % 4 * 4];
      for (std::size_t i = 0; i < cells_[0]; ++i) out[i / 4 * 64 + i % 4] = lengths[row[i]];
    }
  }
}

std::vector<double> clearances_at(const PartSet& parts, const Pose& pose, double reach, const double* points,
                                  std::size_t n) {
  const ClearanceGrid grid(parts, pose, reach);
  std::vector<double> out;
  if (!grid.is_fine()) return out;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 p{points[3 * i], points[3 * i + 1], points[3 * i + 2]};
    const Lanes all = grid.from(broadcast(p.x), broadcast(p.y), broadcast(p.z));
    out.insert(out.end(), {grid.from(p), all[kLanes - 1]});
  }
  return out;
}

std::size_t ClearanceGrid::cell_of(std::size_t axis, double x) const {
  return static_cast<std::size_t>(smaller(larger((x - low_[axis]) * per_step_, 0), last_[axis]));
}

}  // namespace plannercheck
