// An order of configurations in which similar ones follow each other, so that the states of a block, and successive
// blocks, need the same pairs.
//
// In: rows of a set. Out: the order in which they are judged; no verdict depends on it. Idea: the first joints move
// most bodies. So rows go into cells between quantiles of the first numbers that vary, and neighbours among cells
// follow each other. Rows that are already in such an order, e.g. along motions, stay as they are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plannercheck {

class StateOrder {
 public:
  // Larger sets are taken in parts: places fit in 16 bits, and parts half as large gain less (measured).
  static constexpr std::size_t kMostRows = 16384;

  // Finds the order of n <= kMostRows rows of `width` finite numbers.
  void find(const double* q, std::size_t n, std::size_t width);

  // The row that is judged as number i.
  std::size_t row(std::size_t i) const { return is_kept_ ? i : order_[i]; }

 private:
  static constexpr std::size_t kColumns = 4, kMostParts = 8;

  // A number of each row, and where its values are cut into parts.
  struct Column {
    std::size_t number, parts;
    std::array<double, kMostParts - 1> cuts;  // the first parts − 1 of them
  };

  bool is_kept_ = true;
  std::size_t columns_ = 0;
  std::array<Column, kColumns> column_;
  std::vector<std::uint16_t> order_, cells_;  // by row
  std::vector<std::uint16_t> route_, next_;   // through all cells; by cell, the place of its next row

  void choose_columns(const double* q, std::size_t n, std::size_t width);
  bool are_alike_already(const double* q, std::size_t n, std::size_t width) const;
  void find_route();
  void find_cells(const double* q, std::size_t n, std::size_t width);
};

}  // namespace plannercheck
