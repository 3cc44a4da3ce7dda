// Pairs of bodies whose relative pose depends on one or two numbers of a configuration only, and the cells of these
// numbers in which they are apart, proved before (plannercheck/checking/apart_cells.py).
//
// In: the cells' flags, configurations. Out: the pairs that may meet, a bit each. Numbers beyond the cells, and NaN,
// leave all pairs. Immutable, and independent of scenes, so all checkers of a robot share them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace plannercheck {

// The cells of a number of the configuration: `count` cells from `low` on, `per_unit` of them a unit.
struct CellsOfColumn {
  std::size_t column;
  double low, per_unit;
  int count;
};

class ApartCells {
 public:
  static constexpr std::size_t kMostPairs = 8;
  static constexpr unsigned kAnything = 0xff;

  // may_meet[i * columns[1].count + k]: a bit for each pair, of cell i of the first number and k of the second.
  ApartCells(const std::array<CellsOfColumn, 2>& columns, const std::vector<std::uint8_t>& may_meet);

  const std::array<CellsOfColumn, 2>& columns() const { return columns_; }

  // The place of a number, a double or a lane of them: 1 to `count` in its cells, 0 or count + 1 beyond them.
  template <class Number>
  static Number place(const CellsOfColumn& cells, Number value) {
    const Number found = (value - cells.low) * cells.per_unit + 1.0, past = Number{} + (cells.count + 1.0);
    const Number least = found > Number{} ? found : Number{};  // of NaN, too
    return least < past ? least : past;
  }
  // Places of the second number follow each other; places of the first number are this far apart.
  int row_length() const { return columns_[1].count + 2; }

  unsigned at_place(int first, int second) const { return at_place(first * row_length() + second); }
  unsigned at_place(int place) const { return may_meet_[static_cast<std::size_t>(place)]; }

  // The pairs that may meet in a state; value(column): a number of its configuration.
  template <class Value>
  unsigned of_state(Value value) const {
    const auto own = [&](const CellsOfColumn& cells) { return static_cast<int>(place(cells, value(cells.column))); };
    return at_place(own(columns_[0]), own(columns_[1]));
  }

 private:
  std::array<CellsOfColumn, 2> columns_;
  std::vector<std::uint8_t> may_meet_;  // by place: with a rim around the cells, where anything may meet
};

// Cells, and the checker's pair that each bit stands for; −1 for none.
struct PairsInCells {
  std::shared_ptr<const ApartCells> cells;
  std::array<std::int32_t, ApartCells::kMostPairs> pairs;
};

}  // namespace plannercheck
