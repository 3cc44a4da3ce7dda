// A small zero-sum game that gains rows and columns, and is solved again from where it was: min over mixtures of rows
// of max over columns.
//
// In: payoffs of one more row or column at a time, and a bound of their size. Out: the value and weights for both
// sides, >= 0 with sum 1. As in game.hpp, an error costs the caller progress, never soundness.
//
// With a_ij = 1 + payoff_ij / (2 bound) > 0, rows maximise Σ z_i over Σ_i a_ij z_i <= 1 for every column j, z >= 0; the
// optimum is the inverse of the value of the game a. Of the tableau only the columns of variables that are 0 are kept:
// x_basic = level − tableau · x_free. A new row of the game is one more free variable, which may improve the optimum
// (primal simplex); a new column is one more basic slack, which may be negative (dual simplex): mostly a pivot or two.
// Arrays are written as they are read, four numbers at a time: a wide load right after narrower stores has to wait
// until these are through, which cost more than the arithmetic.
#pragma once

#include <array>
#include <cstddef>

#include "vec.hpp"

namespace plannercheck {

class GrowingGame {
 public:
  static constexpr int kMost = 8;  // rows and columns
  typedef std::array<double, kMost> Numbers;

  // `bound` > 0: no payoff is larger, in absolute terms.
  explicit GrowingGame(double bound) : unit_(0.5 / bound), total_at_one_(1 / (1 + unit_)) {
    for (auto& row : tableau_) row.fill(0);
    level_.fill(0), gain_.fill(0);
    // Columns that are not there yet have no weight.
    for (int j = 0; j < kMost; ++j) seat_[index(kMost + j)].basic = true;
  }

  // Where the next row or column goes: a free place or, with kMost of them, that of one which has no weight now.
  int place_of_row() const { return rows_ < kMost ? rows_ : weightless_row(); }
  int place_of_column() const { return columns_ < kMost ? columns_ : weightless_column(); }

  // Payoffs of a row against all columns, of a column against all rows.
  void put_row(int place, const Numbers& payoffs);
  void put_column(int place, const Numbers& payoffs);

  // Finds the weights. Afterwards value() is the game's.
  void solve();
  // Forgets rounding: solves from the beginning.
  void solve_afresh();

  // Whether the value is more than 1; after `solve`.
  bool is_above_one() const { return total_ < total_at_one_; }
  Numbers row_weights() const;
  Numbers column_weights() const;

 private:
  typedef Numbers Line;

  // A variable is a row's weight z_i (i) or the slack of column j (kMost + j); it is basic in a line of the tableau or
  // free in a column of it.
  struct Seat {
    bool basic = false;
    int at = 0;
  };

  int rows_ = 0, columns_ = 0;
  double unit_, total_at_one_, total_ = 0;
  std::array<Line, kMost> payoff_;   // scaled: a_ij, by row
  std::array<Line, kMost> tableau_;  // by line
  Line level_;                       // of the basic variables
  Line gain_;                        // of the optimum, by free variable
  std::array<int, kMost> basic_, free_;
  std::array<Seat, 2 * kMost> seat_;

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  Seat seat_of_row(int i) const { return seat_[index(i)]; }
  Seat seat_of_column(int j) const { return seat_[index(kMost + j)]; }

  Numbers basic_rows() const;
  static Numbers normalised(const Numbers& weights);
  int weightless_row() const;
  int weightless_column() const;
  void fill_free(int at, int row);
  void fill_basic(int at, int column);
  void begin();
  bool improve();
  bool restore();
  void pivot(int line, int column);
  int leaving(int column) const;
  int entering(int line) const;
};

}  // namespace plannercheck
