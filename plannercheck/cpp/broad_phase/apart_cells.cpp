#include "broad_phase/apart_cells.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "math/vec.hpp"

namespace plannercheck {

ApartCells::ApartCells(const std::array<CellsOfColumn, 2>& columns, const std::vector<std::uint8_t>& may_meet)
    : columns_(columns) {
  for (const CellsOfColumn& each : columns_) {
    // So that places fit in an int.
    if (each.count < 1 || each.count > 1024)
      throw std::invalid_argument("a number has 1 to 1024 cells, not " + std::to_string(each.count));
  }
  const std::size_t rows = at(columns_[0].count), length = at(columns_[1].count);
  if (may_meet.size() != rows * length)
    throw std::invalid_argument(std::to_string(may_meet.size()) + " flags are not of " + std::to_string(rows * length) +
                                " cells");
  may_meet_.assign((rows + 2) * at(row_length()), static_cast<std::uint8_t>(kAnything));
  for (std::size_t i = 0; i < rows; ++i) {
    std::copy_n(may_meet.data() + i * length, length, may_meet_.data() + (i + 1) * at(row_length()) + 1);
  }
}

}  // namespace plannercheck
