// A small zero-sum game, min over mixtures of rows of max over columns, that grows, with a warm start from its last
// solution.
//
// In: payoffs of one more row or column at a time, and a bound of their size. Out: the value and weights for both
// sides, >= 0 with sum 1. As in matrix_game.hpp, an error costs the caller progress, never soundness.
//
// With a_ij = 1 + payoff_ij / (2 bound) > 0, rows maximise Σ z_i over Σ_i a_ij z_i <= 1 for every column j, z >= 0; the
// optimum is the inverse of the value of the game a. Only the tableau's columns of variables that are 0 are kept:
// x_basic = level − tableau · x_free. A new row of the game is one more free variable, which may improve the optimum
// (primal simplex). A new column is one more basic slack, which may be negative (dual simplex). Mostly a pivot or two
// do.
//
// Latency and unpredictable branches bound a step, not arithmetic. So the tableau is stored twice, by line and by
// column, and both are read as they are written, four numbers at a time (a wide load after narrower stores is a
// store-forwarding stall). A variable's basis position is an address, so that no branch depends on whether it is basic.
// Games of up to four rows and columns use the first four numbers of every line.
#pragma once

#include <array>
#include <cstddef>

#include "math/vec.hpp"

namespace plannercheck {

class IncrementalMatrixGame {
 public:
  static constexpr int kMost = 8;  // rows and columns
  typedef std::array<double, kMost> Numbers;

  // `bound` > 0: an upper bound of the payoffs' absolute values.
  explicit IncrementalMatrixGame(double bound);

  // A game of some rows and columns, as if these had been put one by one. Payoffs in either order; those of absent rows
  // and columns are ignored.
  typedef std::array<Numbers, kMost> Payoffs;
  IncrementalMatrixGame(double bound, int rows, int columns, const Payoffs& by_row, const Payoffs& by_column);

  // The place of the next row or column: a free one or, when kMost are taken, that of one without weight.
  int place_of_row() const { return rows_ < kMost ? rows_ : weightless_row(); }
  int place_of_column() const { return columns_ < kMost ? columns_ : weightless_column(); }

  // Payoffs of a row against all columns, or of a column against all rows; numbers for absent ones are ignored.
  void put_row(int place, const Numbers& payoffs);
  void put_column(int place, const Numbers& payoffs);

  // Finds the weights.
  void solve();
  // Solves from the beginning, which drops accumulated rounding.
  void solve_afresh();

  // Whether the value exceeds 1; after `solve`.
  bool is_above_one() const { return total_ < total_at_one_; }
  Numbers row_weights() const;
  Numbers column_weights() const;

 private:
  typedef Numbers Line;

  // A variable is a row's weight z_i (i) or the slack of column j (kMost + j). Its basis position is its line of the
  // tableau while it is basic, kMost + its column of the tableau while it is free.
  int rows_ = 0, columns_ = 0;
  bool wide_ = false;  // more than four rows or columns
  double unit_, total_at_one_, total_ = 0;
  std::array<int, 2 * kMost> position_, variable_at_;  // by variable, by position
  // By basis position; zeros where a basic variable has no gain or a free one no level.
  alignas(64) std::array<double, 2 * kMost> level_, gain_;
  // Lines of the tableau, negated; unit vectors; columns of the tableau.
  std::array<Line, 3 * kMost> numbers_;
  std::array<Line, kMost> payoff_;  // a_ij, by row

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  int position_of_row(int i) const { return position_[index(i)]; }
  int position_of_column(int j) const { return position_[index(kMost + j)]; }
  static bool is_basic(int position) { return position < kMost; }
  double* unit_line(int k) { return numbers_[index(kMost + k)].data(); }
  double* tableau_line(int line) { return numbers_[index(line)].data(); }
  double* tableau_column(int column) { return numbers_[index(2 * kMost + column)].data(); }
  // The line of a variable in terms of the free ones; the column of a slack in the whole tableau.
  const double* line_of(int position) const { return numbers_[index(position)].data(); }
  const double* column_of(int position) const { return numbers_[index(kMost + position)].data(); }

  int weightless_row() const;
  int weightless_column() const;
  void set_position(int variable, int position);
  void widen();
  template <int kVectors>
  void clear();
  template <int kVectors>
  void fill_column(int column, const Line& a);
  template <int kVectors>
  void fill_line(int line, const Line& a);
  void begin();
  template <int kVectors>
  void begin_with(const Payoffs& by_row, const Payoffs& by_column);
  template <int kVectors>
  void solve_in();
  template <int kVectors>
  bool improve();
  template <int kVectors>
  bool restore();
  template <int kVectors>
  void pivot(int line, int column, double inverse);
  Numbers weights_of(int first, const std::array<double, 2 * kMost>& by_seat, double sign) const;
};

}  // namespace plannercheck
