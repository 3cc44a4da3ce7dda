// How far points are at least from all parts of a set that stands still: a byte for each cell of a grid.
//
// In: a posed set, the region of the world where points are asked for. Out: for points in lanes, lower bounds of their
// distances to the parts. Idea: cells that hold parts (of balls: their centres) are marked, and each cell keeps by how
// many cells it is away from the nearest marked one, in Euclid's length, which is found axis by axis (Felzenszwalb and
// Huttenlocher 2012). All that is beyond a side where parts lie outside of the grid counts as marked.
//
// Proof. Let x be a point in a closed cell, p one in another, whose indices differ by k on an axis: then the points
// differ there by at least (|k| − 1) steps. A point outside of the grid is taken to the nearest cell. On a side beyond
// which no part is that brings it no further from any of them on any axis; beyond any other side the cells' own
// distance is 0. Rounding moves points by less than `room_`, which is taken off.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bodies/part_set.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class ClearanceGrid {
 public:
  // Of the world's cube of |x|, |y|, |z| <= reach.
  ClearanceGrid(const PartSet& parts, const Pose& pose, double reach);

  // Lower bounds of the distances to the parts, m; negative ones, too. Of points that are no numbers: whatever.
  Lanes from(Lanes x, Lanes y, Lanes z) const {
    const Cells i = cell(0, x), j = cell(1, y), k = cell(2, z);
    const Cells block = ((k >> 2) * rows_ + (j >> 2)) * row_ + (i >> 2);
    const Cells index = (block << 6) | ((k & 3) << 4) | ((j & 3) << 2) | (i & 3);
    return __builtin_convertvector(gathered_bytes(values_.data(), index), Lanes) * unit_ - room_;
  }

  // The same of one point.
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
