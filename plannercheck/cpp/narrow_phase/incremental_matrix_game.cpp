#include "narrow_phase/incremental_matrix_game.hpp"

#include <array>

#include "math/double4_array.hpp"
#include "math/vec.hpp"

namespace plannercheck {
namespace {

// Levels and gains are of the order of 1; numbers nearer to 0 than this are rounding.
constexpr double kNoise = 1e-14;
// A pivot that is so much smaller than the largest possible one is a rounded 0.
constexpr double kSmallestPivot = 1e-11;
constexpr double kNever = __builtin_inf();

// Mostly only the row or column added last can enter.
bool is_one(unsigned bits) { return (bits & (bits - 1)) == 0; }

}  // namespace

GrowingGame::GrowingGame(double bound) : unit_(0.5 / bound), total_at_one_(1 / (1 + unit_)) {
  // Absent rows are free, absent columns basic: neither has weight.
  for (std::size_t i = 0; i < kMost; ++i) seat_[i] = kMost, seat_[kMost + i] = 0;
  level_.fill(0), gain_.fill(0);
  clear<1>();
}

void GrowingGame::sit(int variable, int seat) {
  seat_[index(variable)] = seat;
  sitting_[index(seat)] = variable;
}

template <int kQuads>
void GrowingGame::clear() {
  for (int i = 0; i < kQuads * kQuad; ++i) {
    const auto none = Few<kQuads>::all(0);
    none.store(tableau_line(i)), none.store(tableau_column(i));
    Place<kQuads>(i).with(none, 1).store(unit_line(i));
  }
}

// Widens every line from four numbers to eight.
void GrowingGame::widen() {
  wide_ = true;
  for (int i = 0; i < kMost; ++i) {
    const auto one = Place<2>(i).with(Few<2>::all(0), 1);
    one.store(unit_line(i));
    for (double* line : {tableau_line(i), tableau_column(i)}) {
      if (i >= kQuad) store_quad(line, Quad{});
      store_quad(line + kQuad, Quad{});
    }
  }
}

// Sets up a new row: what it takes from each basic variable, and its gain.
template <int kQuads>
void GrowingGame::fill_column(int column, const Line& a) {
  auto line = Few<kQuads>::all(0);
  double gain = 1;
  for (int j = 0; j < kQuads * kQuad; ++j) {
    const int seat = seat_of_column(j);
    line = line + a[index(j)] * Few<kQuads>::load(column_of(seat));
    gain += a[index(j)] * gain_[index(seat)];
  }
  const Place<kQuads> place(column);
  line.store(tableau_column(column));
  for (int i = 0; i < kQuads * kQuad; ++i) {
    double* const other = tableau_line(i);
    place.with(Few<kQuads>::load(other), -line[i / kQuad][i % kQuad]).store(other);
  }
  double* const gains = gain_.data() + kMost;
  place.with(Few<kQuads>::load(gains), gain).store(gains);
}

// Sets up a new column: its slack in terms of the free variables.
template <int kQuads>
void GrowingGame::fill_line(int line, const Line& a) {
  auto numbers = Few<kQuads>::all(0);
  double level = 1;
  for (int i = 0; i < kQuads * kQuad; ++i) {
    const int seat = seat_of_row(i);
    numbers = numbers + a[index(i)] * Few<kQuads>::load(line_of(seat));
    level -= a[index(i)] * level_[index(seat)];
  }
  const Place<kQuads> place(line);
  (-numbers).store(tableau_line(line));
  for (int i = 0; i < kQuads * kQuad; ++i) {
    double* const other = tableau_column(i);
    place.with(Few<kQuads>::load(other), numbers[i / kQuad][i % kQuad]).store(other);
  }
  place.with(Few<kQuads>::load(level_.data()), level).store(level_.data());
}

// Among the rows without weight, the one that would lower the optimum most.
int GrowingGame::weightless_row() const {
  int worst = -1;
  for (int i = 0; i < rows_; ++i) {
    const int seat = seat_of_row(i);
    if (is_basic(seat)) continue;
    if (worst < 0 || gain_[index(seat)] < gain_[index(seat_of_row(worst))]) worst = i;
  }
  return worst < 0 ? 0 : worst;
}

// Among the columns without weight, the one with most slack.
int GrowingGame::weightless_column() const {
  int loosest = -1;
  for (int j = 0; j < columns_; ++j) {
    const int seat = seat_of_column(j);
    if (!is_basic(seat)) continue;
    if (loosest < 0 || level_[index(seat)] > level_[index(seat_of_column(loosest))]) loosest = j;
  }
  return loosest < 0 ? 0 : loosest;
}

void GrowingGame::put_row(int place, const Numbers& payoffs) {
  if (place >= kQuad && !wide_) widen();
  const auto scaled = Few<2>::all(1) + unit_ * Few<2>::load(payoffs.data());
  scaled.store(payoff_[index(place)].data());
  Line a;
  first_of(scaled, columns_).store(a.data());
  if (place == rows_) sit(place, kMost + rows_++);
  const int seat = seat_of_row(place);
  if (is_basic(seat)) return begin();  // degenerate: all have weight
  wide_ ? fill_column<2>(seat - kMost, a) : fill_column<1>(seat - kMost, a);
}

void GrowingGame::put_column(int place, const Numbers& payoffs) {
  if (place >= kQuad && !wide_) widen();
  const auto scaled = Few<2>::all(1) + unit_ * Few<2>::load(payoffs.data());
  for (int i = 0; i < rows_; ++i) payoff_[index(i)][index(place)] = scaled[i / kQuad][i % kQuad];
  Line a;
  first_of(scaled, rows_).store(a.data());
  if (place == columns_) sit(kMost + place, columns_++);
  const int seat = seat_of_column(place);
  if (!is_basic(seat)) return begin();
  wide_ ? fill_line<2>(seat, a) : fill_line<1>(seat, a);
}

void GrowingGame::begin() {
  wide_ = true;
  total_ = 0;
  level_.fill(0), gain_.fill(0);
  clear<2>();
  for (int i = 0; i < rows_; ++i) sit(i, kMost + i), gain_[index(kMost + i)] = 1;
  for (int j = 0; j < columns_; ++j) {
    sit(kMost + j, j), level_[index(j)] = 1;
    for (int i = 0; i < rows_; ++i) {
      const double a = payoff_[index(i)][index(j)];
      tableau_line(j)[i] = -a, tableau_column(i)[j] = a;
    }
  }
}

template <int kQuads>
void GrowingGame::pivot(int line, int column, double inverse) {
  typedef Few<kQuads> Line;
  const Place<kQuads> by_column(column), by_line(line);
  double* const chosen_line = tableau_line(line);
  double* const chosen_column = tableau_column(column);
  double* const gains = gain_.data() + kMost;
  const Line scaled = -inverse * by_column.with(Line::load(chosen_line), -1);
  const Line taken = by_line.with(Line::load(chosen_column), -1);
  const double level = level_[index(line)] * inverse, gain = gains[column];
  (by_line.with(Line::load(level_.data()), 0) - level * taken).store(level_.data());
  (by_column.with(Line::load(gains), 0) - gain * scaled).store(gains);
  total_ += gain * level;
  for (int i = 0; i < kQuads * kQuad; ++i) {
    double* const other = tableau_line(i);
    (by_column.with(Line::load(other), 0) + taken[i / kQuad][i % kQuad] * scaled).store(other);
  }
  for (int i = 0; i < kQuads * kQuad; ++i) {
    double* const other = tableau_column(i);
    (by_line.with(Line::load(other), 0) - scaled[i / kQuad][i % kQuad] * taken).store(other);
  }
  (-scaled).store(chosen_line);
  (-inverse * taken).store(chosen_column);
  const int leaves = sitting_[index(line)], enters = sitting_[index(kMost + column)];
  sit(enters, line), sit(leaves, kMost + column);
}

// One step of the primal simplex; false at the optimum. The line that bounds the free variable first leaves; among
// equal ones, which flat stars have, the one with the largest pivot.
template <int kQuads>
bool GrowingGame::improve() {
  const auto gain = Few<kQuads>::load(gain_.data() + kMost);
  const unsigned better = above(gain, kNoise);
  if (better == 0) return false;
  const int column = is_one(better) ? __builtin_ctz(better) : place(gain, most(gain));
  if (column >= rows_) return false;  // comparisons with NaN found none
  const auto pivots = Few<kQuads>::load(tableau_column(column));
  const double smallest = kSmallestPivot * most(pivots);
  if (!(smallest > 0)) return false;
  const auto inverses = Few<kQuads>::of([&](int i) { return 1 / pivots[i]; });
  const auto level = Few<kQuads>::load(level_.data());
  const auto ratios =
      Few<kQuads>::of([&](int i) { return pivots[i] > smallest ? level[i] * inverses[i] : Quad{} + kNever; });
  unsigned first = equals(ratios, least(ratios));
  int line = __builtin_ctz(first | 1U << kMost);
  if (line >= columns_) return false;
  for (first &= first - 1; first != 0; first &= first - 1) {
    const int other = __builtin_ctz(first);
    if (tableau_column(column)[other] > tableau_column(column)[line]) line = other;
  }
  pivot<kQuads>(line, column, inverses[line / kQuad][line % kQuad]);
  return true;
}

// One step of the dual simplex; false if no level is negative. The free variable that repairs the line at the least
// cost enters.
template <int kQuads>
bool GrowingGame::restore() {
  const auto level = Few<kQuads>::load(level_.data());
  const unsigned negative = above(-level, kNoise);
  if (negative == 0) return false;
  const int line = is_one(negative) ? __builtin_ctz(negative) : place(level, least(level));
  const auto pivots = Few<kQuads>::load(tableau_line(line));  // negated
  const double smallest = kSmallestPivot * most(pivots);
  if (!(smallest > 0)) return false;
  const auto inverses = Few<kQuads>::of([&](int i) { return -1 / pivots[i]; });
  const auto gain = Few<kQuads>::load(gain_.data() + kMost);
  const auto ratios =
      Few<kQuads>::of([&](int i) { return pivots[i] > smallest ? gain[i] * inverses[i] : Quad{} + kNever; });
  const int column = place(ratios, least(ratios));
  if (column >= rows_) return false;
  pivot<kQuads>(line, column, inverses[column / kQuad][column % kQuad]);
  return true;
}

template <int kQuads>
void GrowingGame::solve_in() {
  const int limit = 4 * (rows_ + columns_);  // rounding may cycle; the current weights are then used
  for (int step = 0; step < limit; ++step) {
    if (!restore<kQuads>() && !improve<kQuads>()) break;
  }
}

void GrowingGame::solve() { wide_ ? solve_in<2>() : solve_in<1>(); }

void GrowingGame::solve_afresh() {
  begin();
  solve();
}

GrowingGame::Numbers GrowingGame::weights_of(int first, const std::array<double, 2 * kMost>& by_seat,
                                             double sign) const {
  const auto weight = [&](int i) { return larger(0.0, sign * by_seat[index(seat_[index(first + i)])]); };
  const Few<2> weights{{Quad{weight(0), weight(1), weight(2), weight(3)},
                        wide_ ? Quad{weight(4), weight(5), weight(6), weight(7)} : Quad{}}};
  const double inverse = 1 / sum(weights);
  Numbers out;
  if (inverse > 0 && inverse < kNever) {
    (inverse * weights).store(out.data());
  } else {
    Place<2>(0).with(Few<2>::all(0), 1).store(out.data());
  }
  return out;
}

GrowingGame::Numbers GrowingGame::row_weights() const { return weights_of(0, level_, 1); }
GrowingGame::Numbers GrowingGame::column_weights() const { return weights_of(kMost, gain_, -1); }

}  // namespace plannercheck
