// The solver's games in Python, to hold them against linear programs and to time them.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "array_types.hpp"
#include "bindings.hpp"
#include "growing_game.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using Payoffs = InputArray<double, -1, -1, -1>;

// A game that gains a row and a column by turns, as in a search, and is solved again each time.
void play(GrowingGame& game, const double* payoffs, std::size_t rows, std::size_t columns) {
  for (std::size_t k = 0; k < std::max(rows, columns); ++k) {
    GrowingGame::Numbers line{};
    if (k < rows) {
      std::copy_n(payoffs + k * columns, std::min(k, columns), line.begin());
      game.put_row(game.place_of_row(), line);
      if (k > 0) game.solve();
    }
    if (k < columns) {
      for (std::size_t row = 0; row < std::min(k + 1, rows); ++row) line[row] = payoffs[row * columns + k];
      game.put_column(game.place_of_column(), line);
      game.solve();
    }
  }
}

// Weights of the rows, who want little, and of the columns, kMost each, of games (n, rows, columns); no payoff is
// beyond the bound.
nb::tuple solve_games(Payoffs payoffs, double bound) {
  constexpr auto kMost = static_cast<std::size_t>(GrowingGame::kMost);
  const std::size_t n = payoffs.shape(0), rows = payoffs.shape(1), columns = payoffs.shape(2);
  if (rows == 0 || columns == 0 || rows > kMost || columns > kMost) {
    throw std::invalid_argument("a game has 1 to 8 rows and columns");
  }
  std::vector<double> of_rows(n * kMost), of_columns(n * kMost);
  for (std::size_t i = 0; i < n; ++i) {
    GrowingGame game(bound);
    play(game, payoffs.data() + i * rows * columns, rows, columns);
    const GrowingGame::Numbers r = game.row_weights(), c = game.column_weights();
    std::copy(r.begin(), r.end(), of_rows.begin() + static_cast<std::ptrdiff_t>(i * kMost));
    std::copy(c.begin(), c.end(), of_columns.begin() + static_cast<std::ptrdiff_t>(i * kMost));
  }
  return nb::make_tuple(output_array(of_rows, {n, kMost}), output_array(of_columns, {n, kMost}));
}

}  // namespace

void bind_game(nb::module_& m) { m.def("solve_games", &solve_games, nb::arg("payoffs"), nb::arg("bound")); }

}  // namespace plannercheck
