// Lower bounds of the distance of points from all parts of a static set: a byte for each cell of a grid.
//
// In: a posed set, the region of the world where points are asked for. Out: for points in lanes, lower bounds of their
// distances to the parts. Idea: cells that hold parts (of balls: their centres) are marked, and each cell stores its
// Euclidean distance, in cells, from the nearest marked cell, computed axis by axis (Felzenszwalb and Huttenlocher
// 2012). If parts lie outside of the grid beyond a side, all cells beyond that side count as marked.
//
// Proof. Let x and p be points in closed cells whose indices differ by k on an axis: then x and p differ on it by at
// least (|k| − 1) steps. A point outside of the grid gets the bound of the nearest cell. If no part is beyond that
// side, the nearest cell is no further from any part on any axis; beyond any other side, the bound is 0. Rounding moves
// points by less than `room_`, which is subtracted.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bodies/part_set.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class ClearanceGrid {
 public:
  // The grid is within the world's cube |x|, |y|, |z| <= reach.
  ClearanceGrid(const PartSet& parts, const Pose& pose, double reach);

  // Lower bounds of the distances to the parts, m; may be negative. Undefined for NaN.
  Lanes from(Lanes x, Lanes y, Lanes z) const {
    const Cells i = cell(0, x), j = cell(1, y), k = cell(2, z);
    const Cells block = ((k >> 2) * rows_ + (j >> 2)) * row_ + (i >> 2);
    const Cells index = (block << 6) | ((k & 3) << 4) | ((j & 3) << 2) | (i & 3);
    return __builtin_convertvector(gathered_bytes(values_.data(), index), Lanes) * unit_ - room_;
  }

  // For one point.
  double from(Vec3 p) const {
    const std::int32_t i = cell(0, p.x), j = cell(1, p.y), k = cell(2, p.z);
    return values_[index_of(i, j, k)] * unit_ - room_;
  }
  // Whether its steps are short enough to say anything of a robot's links.
  bool is_fine() const { return !values_.empty(); }

 private:
  typedef LaneIndices Cells;
  class Marking;

  std::array<std::size_t, 3> cells_{1, 1, 1};
  std::array<double, 3> low_{}, last_{};  // the low corner; the last cell of an axis
  std::array<bool, 6> closed_{};          // sides, the low ones first, beyond which parts may be
  std::int32_t row_ = 1, rows_ = 1;       // blocks in a row, rows of them in a layer
  double step_ = 1, per_step_ = 1, unit_ = 1, room_ = 0;
  std::vector<std::uint8_t> values_;

  void lay_out(const Vec3& low, const Vec3& high);
  template <class Rows>
  void keep_lengths(const Rows& squares);
  std::size_t cell_of(std::size_t axis, double x) const;

  std::int32_t cell(std::size_t axis, double x) const {
    return static_cast<std::int32_t>(smaller(larger((x - low_[axis]) * per_step_, 0), last_[axis]));
  }
  std::size_t index_of(std::int32_t i, std::int32_t j, std::int32_t k) const {
    const std::int32_t block = ((k >> 2) * rows_ + (j >> 2)) * row_ + (i >> 2);
    return at(block << 6 | (k & 3) << 4 | (j & 3) << 2 | (i & 3));
  }

  // The cell that holds a place, up to rounding; any for what is no number.
  Cells cell(std::size_t axis, Lanes x) const {
    const Lanes place = larger((x - low_[axis]) * per_step_, Lanes{});
    return __builtin_convertvector(smaller(place, broadcast(last_[axis])), Cells);
  }
};

}  // namespace plannercheck
