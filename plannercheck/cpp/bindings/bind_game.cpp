// The solver's games in Python, to compare them with linear programs and to time them.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "narrow_phase/incremental_matrix_game.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using Payoffs = InputArray<double, -1, -1, -1>;

constexpr auto kMost = static_cast<std::size_t>(IncrementalMatrixGame::kMost);
// Games are written this many at a time before they are solved: reading lines right after they were written number by
// number would stall, which is not to be timed.
constexpr std::size_t kAtOnce = 16;

struct Game {
  std::array<IncrementalMatrixGame::Numbers, kMost> by_row{}, by_column{};

  void write(const double* payoffs, std::size_t rows, std::size_t columns) {
    for (std::size_t i = 0; i < rows; ++i) {
      for (std::size_t j = 0; j < columns; ++j) by_row[i][j] = by_column[j][i] = *payoffs++;
    }
  }

  // Adds a row and a column in turn, as a search does, and solves the game each time. It begins with some of both.
  IncrementalMatrixGame play(double bound, std::size_t rows, std::size_t columns, std::size_t at_once) const {
    IncrementalMatrixGame game(bound);
    if (at_once > 0) {
      game = IncrementalMatrixGame(bound, static_cast<int>(std::min(at_once, rows)),
                                   static_cast<int>(std::min(at_once, columns)), by_row, by_column);
      game.solve();
    }
    for (std::size_t k = at_once; k < std::max(rows, columns); ++k) {
      if (k < rows) {
        game.put_row(game.place_of_row(), by_row[k]);
        if (k > 0) game.solve();
      }
      if (k < columns) {
        game.put_column(game.place_of_column(), by_column[k]);
        game.solve();
      }
    }
    return game;
  }
};

// Weights of the minimising rows and the maximising columns, kMost each, of games (n, rows, columns); `bound` holds for
// all. Games begin with `at_once` rows and columns, or with what they have of them.
nb::tuple solve_games(Payoffs payoffs, double bound, std::size_t at_once) {
  const std::size_t n = payoffs.shape(0), rows = payoffs.shape(1), columns = payoffs.shape(2);
  if (rows == 0 || columns == 0 || rows > kMost || columns > kMost) {
    throw std::invalid_argument("a game has 1 to 8 rows and columns");
  }
  std::vector<double> of_rows(n * kMost), of_columns(n * kMost);
  std::array<Game, kAtOnce> games;
  for (std::size_t i = 0; i < n; ++i) {
    if (i % kAtOnce == 0) {
      for (std::size_t k = i; k < std::min(i + kAtOnce, n); ++k) {
        games[k - i].write(payoffs.data() + k * rows * columns, rows, columns);
      }
    }
    const IncrementalMatrixGame solved = games[i % kAtOnce].play(bound, rows, columns, at_once);
    const IncrementalMatrixGame::Numbers r = solved.row_weights(), c = solved.column_weights();
    std::copy(r.begin(), r.end(), of_rows.begin() + static_cast<std::ptrdiff_t>(i * kMost));
    std::copy(c.begin(), c.end(), of_columns.begin() + static_cast<std::ptrdiff_t>(i * kMost));
  }
  return nb::make_tuple(output_array(of_rows, {n, kMost}), output_array(of_columns, {n, kMost}));
}

}  // namespace

void bind_game(nb::module_& m) {
  m.def("solve_games", &solve_games, nb::arg("payoffs"), nb::arg("bound"), nb::arg("at_once") = 0, plain_floats);
}

}  // namespace plannercheck
