// An upper bound of a height field near a place: one look-up in a table, instead of a descent in a tree.
//
// In: heights over a lattice, and their base. Out: levels of cells, each cell twice as wide as the cells of the level
// before, up to one cell around all; and for each cell its ceiling: no prism whose square is in the cell or in one of
// its eight neighbours is higher. So a body that sticks out of a cell by less than a cell's width, and is above its
// ceiling, meets no prism. Ceilings are counted in units above the base, rounded upwards; cells lie in tiles of a cache
// line each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

class HeightCeilings {
 public:
  // Cells of a level, along x and y.
  struct Level {
    std::array<std::int32_t, 2> cells;
    std::array<double, 2> width;  // of a cell, m
    std::int32_t tiles;           // in a row along y
    std::int32_t first;           // place of the first ceiling
  };

  // heights (rows, columns) over steps along x and y, m; NaN where there is none. `corner`: x and y of the first one,
  // and the base.
  HeightCeilings(const double* heights, std::size_t rows, std::size_t columns, std::array<double, 2> step, Vec3 corner);

  const std::vector<Level>& levels() const { return levels_; }
  // One more is there to be read with the last one.
  const std::uint16_t* values() const { return values_.data(); }
  Vec3 corner() const { return corner_; }
  double unit() const { return unit_; }  // m

  // The place of a cell's ceiling after the level's first one; indices are integers or lanes of them.
  template <class Index>
  static Index place(Index i, Index j, Index tiles) {
    return ((i >> 2) * tiles + (j >> 3)) << 5 | (i & 3) << 3 | (j & 7);
  }

 private:
  struct Cells;

  Vec3 corner_;
  double unit_ = 1;
  std::vector<Level> levels_;
  std::vector<std::uint16_t> values_;

  std::uint16_t counted(double height) const;
  void keep(const Cells& cells, std::array<double, 2> width);
};

}  // namespace plannercheck
