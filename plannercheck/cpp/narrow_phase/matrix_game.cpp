#include "narrow_phase/matrix_game.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

#include "math/vec.hpp"

namespace plannercheck {
namespace {

// A pivot that is so much smaller than others of its column is a rounded 0. A row through a degenerate corner would be
// chosen for it, and the tableau lost.
constexpr double kPivotRounding = 1e-11;

// maximise Σ z_i over Σ_i (a_ij + shift) z_i <= 1 for every column j, z >= 0. With the payoffs shifted to be positive
// the optimum is 1 / (value + shift); z is proportional to the rows' weights, the prices to the columns'.
class Tableau {
 public:
  Tableau(const Game& game, double shift) : constraints_(game.columns), variables_(game.rows) {
    entry(constraints_, variables_) = 0;
    for (int j = 0; j < constraints_; ++j) {
      for (int i = 0; i < variables_; ++i) entry(j, i) = game.payoff[at(i)][at(j)] + shift;
      entry(j, variables_) = 1;
      basic_[at(j)] = variables_ + j;
    }
    for (int i = 0; i < variables_; ++i) {
      entry(constraints_, i) = 1;
      free_[at(i)] = i;
    }
  }

  void optimise() {
    const int limit = 4 * (constraints_ + variables_);  // rounding may cycle; the current weights are then used
    for (int step = 0; step < limit; ++step) {
      const int column = entering();
      if (column < 0) return;
      const int row = leaving(column);
      if (row < 0) return;
      pivot(row, column);
    }
  }

  void read(Mixture& mixture) const {
    for (int i = 0; i < variables_; ++i) mixture.row[at(i)] = 0;
    for (int j = 0; j < constraints_; ++j) mixture.column[at(j)] = 0;
    for (int j = 0; j < constraints_; ++j) {
      if (basic_[at(j)] < variables_) mixture.row[at(basic_[at(j)])] = larger(0.0, entry(j, variables_));
    }
    for (int i = 0; i < variables_; ++i) {
      if (free_[at(i)] >= variables_)
        mixture.column[at(free_[at(i)] - variables_)] = larger(0.0, -entry(constraints_, i));
    }
  }

 private:
  int constraints_, variables_;
  std::array<std::array<double, kMaxActives + 1>, kMaxActives + 1> entries_;  // the right-hand side comes last
  std::array<int, kMaxActives> basic_, free_;

  double& entry(int row, int column) { return entries_[at(row)][at(column)]; }
  double entry(int row, int column) const { return entries_[at(row)][at(column)]; }

  int entering() const {
    int best = -1;
    double largest = 1e-14;  // prices are of the order of 1: smaller ones are rounding
    for (int i = 0; i < variables_; ++i) {
      if (entry(constraints_, i) > largest) largest = entry(constraints_, i), best = i;
    }
    return best;
  }

  // The row that bounds the column first; among equal ones, which flat stars have, the one with the largest pivot.
  int leaving(int column) const {
    double largest = 0;
    for (int j = 0; j < constraints_; ++j) largest = larger(largest, entry(j, column));
    const double smallest_pivot = larger(kPivotRounding * largest, 1e-300);
    int best = -1;
    double smallest = 0;
    for (int j = 0; j < constraints_; ++j) {
      if (!(entry(j, column) > smallest_pivot)) continue;
      const double ratio = entry(j, variables_) / entry(j, column);
      const bool first = best < 0 || ratio < smallest;
      if (first || (ratio == smallest && entry(j, column) > entry(best, column))) smallest = ratio, best = j;
    }
    return best;
  }

  void pivot(int row, int column) {
    const double inverse = 1 / entry(row, column);
    for (int i = 0; i <= variables_; ++i) entry(row, i) *= inverse;
    entry(row, column) = inverse;
    for (int j = 0; j <= constraints_; ++j) {
      if (j == row) continue;
      const double factor = entry(j, column);
      entry(j, column) = 0;
      for (int i = 0; i <= variables_; ++i) entry(j, i) -= factor * entry(row, i);
    }
    std::swap(basic_[at(row)], free_[at(column)]);
  }
};

void normalise(std::array<double, kMaxActives>& weights, int count) {
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += weights[at(i)];
  for (int i = 0; i < count; ++i) {
    double& w = weights[at(i)];
    w = sum > 0 && std::isfinite(sum) ? w / sum : (i == 0 ? 1.0 : 0.0);
  }
}

}  // namespace

void solve(const Game& game, Mixture& mixture) {
  double lowest = game.payoff[0][0], highest = lowest;
  for (int i = 0; i < game.rows; ++i) {
    for (int j = 0; j < game.columns; ++j) {
      lowest = smaller(lowest, game.payoff[at(i)][at(j)]);
      highest = larger(highest, game.payoff[at(i)][at(j)]);
    }
  }
  // The shift keeps the entries near the spread in size, so that the tableau's rounding is relative to the spread.
  const double spread = highest > lowest ? highest - lowest : 1;
  Tableau tableau(game, spread - lowest);
  tableau.optimise();
  tableau.read(mixture);
  double total = 0;
  for (int i = 0; i < game.rows; ++i) total += mixture.row[at(i)];
  mixture.value = total > 0 ? 1 / total - (spread - lowest) : highest;
  normalise(mixture.row, game.rows);
  normalise(mixture.column, game.columns);
}

}  // namespace plannercheck
