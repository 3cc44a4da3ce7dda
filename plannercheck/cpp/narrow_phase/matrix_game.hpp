// Small zero-sum games: min over mixtures of rows of max over columns.
//
// In: payoffs a[i][j] of at most kMaxActives rows and columns. Out: weights for both sides, >= 0 with sum 1. The
// weights are valid weights whatever the rounding, so a solver's error costs the caller progress, never soundness.
#pragma once

#include <array>

namespace plannercheck {

inline constexpr int kMaxActives = 16;

struct Game {
  int rows = 0, columns = 0;
  std::array<std::array<double, kMaxActives>, kMaxActives> payoff;  // payoff[row][column]
};

struct Mixture {
  std::array<double, kMaxActives> row, column;
  double value = 0;
};

// Solves the linear program of the rows' side by the simplex method on a condensed tableau.
void solve(const Game& game, Mixture& mixture);

}  // namespace plannercheck
