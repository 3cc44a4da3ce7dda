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

IncrementalMatrixGame::IncrementalMatrixGame(double bound) : unit_(0.5 / bound), total_at_one_(1 / (1 + unit_)) {
  // Absent rows are free, absent columns basic: neither has weight.
  for (std::size_t i = 0; i < kMost; ++i) position_[i] = kMost, position_[kMost + i] = 0;
  level_.fill(0), gain_.fill(0);
  clear<1>();
}

IncrementalMatrixGame::IncrementalMatrixGame(double bound, int rows, int columns, const Payoffs& by_row,
                                             const Payoffs& by_column)
    : rows_(rows),
      columns_(columns),
      wide_(rows > kDouble4Lanes || columns > kDouble4Lanes),
      unit_(0.5 / bound),
      total_at_one_(1 / (1 + unit_)) {
  for (int i = 0; i < kMost; ++i) position_[index(i)] = kMost, position_[index(kMost + i)] = 0;
  for (int i = 0; i < rows; ++i) set_position(i, kMost + i);
  for (int j = 0; j < columns; ++j) set_position(kMost + j, j);
  const auto ones = Double4Array<2>::all(1);
  first_of(ones, columns).store(level_.data()), first_of(ones, 0).store(level_.data() + kMost);
  first_of(ones, 0).store(gain_.data()), first_of(ones, rows).store(gain_.data() + kMost);
  wide_ ? begin_with<2>(by_row, by_column) : begin_with<1>(by_row, by_column);
}

// What `begin` does, by whole lines.
template <int kVectors>
void IncrementalMatrixGame::begin_with(const Payoffs& by_row, const Payoffs& by_column) {
  clear<kVectors>();
  const auto scaled = [this](const Numbers& payoffs) {
    return Double4Array<kVectors>::all(1) + unit_ * Double4Array<kVectors>::load(payoffs.data());
  };
  for (int i = 0; i < rows_; ++i) {
    const auto row = scaled(by_row[index(i)]);
    row.store(payoff_[index(i)].data());
    first_of(row, columns_).store(tableau_column(i));
  }
  for (int j = 0; j < columns_; ++j) (-first_of(scaled(by_column[index(j)]), rows_)).store(tableau_line(j));
}

void IncrementalMatrixGame::set_position(int variable, int position) {
  position_[index(variable)] = position;
  variable_at_[index(position)] = variable;
}

template <int kVectors>
void IncrementalMatrixGame::clear() {
  for (int i = 0; i < kVectors * kDouble4Lanes; ++i) {
    const auto none = Double4Array<kVectors>::all(0);
    none.store(tableau_line(i)), none.store(tableau_column(i));
    SingleLaneMask<kVectors>(i).with(none, 1).store(unit_line(i));
  }
}

// Widens every line from four numbers to eight.
void IncrementalMatrixGame::widen() {
  wide_ = true;
  for (int i = 0; i < kMost; ++i) {
    const auto one = SingleLaneMask<2>(i).with(Double4Array<2>::all(0), 1);
    one.store(unit_line(i));
    for (double* line : {tableau_line(i), tableau_column(i)}) {
      if (i >= kDouble4Lanes) store_double4(line, Double4{});
      store_double4(line + kDouble4Lanes, Double4{});
    }
  }
}

// Sets up a new row: what it takes from each basic variable, and its gain.
template <int kVectors>
void IncrementalMatrixGame::fill_column(int column, const Line& a) {
  auto line = Double4Array<kVectors>::all(0);
  double gain = 1;
  for (int j = 0; j < kVectors * kDouble4Lanes; ++j) {
    const int position = position_of_column(j);
    line = line + a[index(j)] * Double4Array<kVectors>::load(column_of(position));
    gain += a[index(j)] * gain_[index(position)];
  }
  const SingleLaneMask<kVectors> place(column);
  line.store(tableau_column(column));
  for (int i = 0; i < kVectors * kDouble4Lanes; ++i) {
    double* const other = tableau_line(i);
    place.with(Double4Array<kVectors>::load(other), -line[i / kDouble4Lanes][i % kDouble4Lanes]).store(other);
  }
  double* const gains = gain_.data() + kMost;
  place.with(Double4Array<kVectors>::load(gains), gain).store(gains);
}

// Sets up a new column: its slack in terms of the free variables.
template <int kVectors>
void IncrementalMatrixGame::fill_line(int line, const Line& a) {
  auto numbers = Double4Array<kVectors>::all(0);
  double level = 1;
  for (int i = 0; i < kVectors * kDouble4Lanes; ++i) {
    const int position = position_of_row(i);
    numbers = numbers + a[index(i)] * Double4Array<kVectors>::load(line_of(position));
    level -= a[index(i)] * level_[index(position)];
  }
  const SingleLaneMask<kVectors> place(line);
  (-numbers).store(tableau_line(line));
  for (int i = 0; i < kVectors * kDouble4Lanes; ++i) {
    double* const other = tableau_column(i);
    place.with(Double4Array<kVectors>::load(other), numbers[i / kDouble4Lanes][i % kDouble4Lanes]).store(other);
  }
  place.with(Double4Array<kVectors>::load(level_.data()), level).store(level_.data());
}

// Among the rows without weight, the one that would lower the optimum most.
int IncrementalMatrixGame::weightless_row() const {
  int worst = -1;
  for (int i = 0; i < rows_; ++i) {
    const int position = position_of_row(i);
    if (is_basic(position)) continue;
    if (worst < 0 || gain_[index(position)] < gain_[index(position_of_row(worst))]) worst = i;
  }
  return worst < 0 ? 0 : worst;
}

// Among the columns without weight, the one with most slack.
int IncrementalMatrixGame::weightless_column() const {
  int loosest = -1;
  for (int j = 0; j < columns_; ++j) {
    const int position = position_of_column(j);
    if (!is_basic(position)) continue;
    if (loosest < 0 || level_[index(position)] > level_[index(position_of_column(loosest))]) loosest = j;
  }
  return loosest < 0 ? 0 : loosest;
}

void IncrementalMatrixGame::put_row(int place, const Numbers& payoffs) {
  if (place >= kDouble4Lanes && !wide_) widen();
  const auto scaled = Double4Array<2>::all(1) + unit_ * Double4Array<2>::load(payoffs.data());
  scaled.store(payoff_[index(place)].data());
  Line a;
  first_of(scaled, columns_).store(a.data());
  if (place == rows_) set_position(place, kMost + rows_++);
  const int position = position_of_row(place);
  if (is_basic(position)) return begin();  // degenerate: all have weight
  wide_ ? fill_column<2>(position - kMost, a) : fill_column<1>(position - kMost, a);
}

void IncrementalMatrixGame::put_column(int place, const Numbers& payoffs) {
  if (place >= kDouble4Lanes && !wide_) widen();
  const auto scaled = Double4Array<2>::all(1) + unit_ * Double4Array<2>::load(payoffs.data());
  for (int i = 0; i < rows_; ++i) payoff_[index(i)][index(place)] = scaled[i / kDouble4Lanes][i % kDouble4Lanes];
  Line a;
  first_of(scaled, rows_).store(a.data());
  if (place == columns_) set_position(kMost + place, columns_++);
  const int position = position_of_column(place);
  if (!is_basic(position)) return begin();
  wide_ ? fill_line<2>(position, a) : fill_line<1>(position, a);
}

void IncrementalMatrixGame::begin() {
  wide_ = true;
  total_ = 0;
  level_.fill(0), gain_.fill(0);
  clear<2>();
  for (int i = 0; i < rows_; ++i) set_position(i, kMost + i), gain_[index(kMost + i)] = 1;
  for (int j = 0; j < columns_; ++j) {
    set_position(kMost + j, j), level_[index(j)] = 1;
    for (int i = 0; i < rows_; ++i) {
      const double a = payoff_[index(i)][index(j)];
      tableau_line(j)[i] = -a, tableau_column(i)[j] = a;
    }
  }
}

template <int kVectors>
void IncrementalMatrixGame::pivot(int line, int column, double inverse) {
  typedef Double4Array<kVectors> Line;
  const SingleLaneMask<kVectors> by_column(column), by_line(line);
  double* const chosen_line = tableau_line(line);
  double* const chosen_column = tableau_column(column);
  double* const gains = gain_.data() + kMost;
  const Line scaled = -inverse * by_column.with(Line::load(chosen_line), -1);
  const Line taken = by_line.with(Line::load(chosen_column), -1);
  const double level = level_[index(line)] * inverse, gain = gains[column];
  (by_line.with(Line::load(level_.data()), 0) - level * taken).store(level_.data());
  (by_column.with(Line::load(gains), 0) - gain * scaled).store(gains);
  total_ += gain * level;
  for (int i = 0; i < kVectors * kDouble4Lanes; ++i) {
    double* const other = tableau_line(i);
    (by_column.with(Line::load(other), 0) + taken[i / kDouble4Lanes][i % kDouble4Lanes] * scaled).store(other);
  }
  for (int i = 0; i < kVectors * kDouble4Lanes; ++i) {
    double* const other = tableau_column(i);
    (by_line.with(Line::load(other), 0) - scaled[i / kDouble4Lanes][i % kDouble4Lanes] * taken).store(other);
  }
  (-scaled).store(chosen_line);
  (-inverse * taken).store(chosen_column);
  const int leaves = variable_at_[index(line)], enters = variable_at_[index(kMost + column)];
  set_position(enters, line), set_position(leaves, kMost + column);
}

// One step of the primal simplex; false at the optimum. The line that bounds the free variable first leaves; among
// equal ones, which flat stars have, the one with the largest pivot.
template <int kVectors>
bool IncrementalMatrixGame::improve() {
  const auto gain = Double4Array<kVectors>::load(gain_.data() + kMost);
  const unsigned better = above(gain, kNoise);
  if (better == 0) return false;
  const int column = is_one(better) ? __builtin_ctz(better) : place(gain, most(gain));
  if (column >= rows_) return false;  // comparisons with NaN found none
  const auto pivots = Double4Array<kVectors>::load(tableau_column(column));
  const double smallest = kSmallestPivot * most(pivots);
  if (!(smallest > 0)) return false;
  const auto inverses = Double4Array<kVectors>::of([&](int i) { return 1 / pivots[i]; });
  const auto level = Double4Array<kVectors>::load(level_.data());
  const auto ratios = Double4Array<kVectors>::of(
      [&](int i) { return pivots[i] > smallest ? level[i] * inverses[i] : Double4{} + kNever; });
  unsigned first = equals(ratios, least(ratios));
  int line = __builtin_ctz(first | 1U << kMost);
  if (line >= columns_) return false;
  for (first &= first - 1; first != 0; first &= first - 1) {
    const int other = __builtin_ctz(first);
    if (tableau_column(column)[other] > tableau_column(column)[line]) line = other;
  }
  pivot<kVectors>(line, column, inverses[line / kDouble4Lanes][line % kDouble4Lanes]);
  return true;
}

// One step of the dual simplex; false if no level is negative. The variable that repairs the line at the least cost
// enters.
template <int kVectors>
bool IncrementalMatrixGame::restore() {
  const auto level = Double4Array<kVectors>::load(level_.data());
  const unsigned negative = above(-level, kNoise);
  if (negative == 0) return false;
  const int line = is_one(negative) ? __builtin_ctz(negative) : place(level, least(level));
  const auto pivots = Double4Array<kVectors>::load(tableau_line(line));  // negated
  const double smallest = kSmallestPivot * most(pivots);
  if (!(smallest > 0)) return false;
  const auto inverses = Double4Array<kVectors>::of([&](int i) { return -1 / pivots[i]; });
  const auto gain = Double4Array<kVectors>::load(gain_.data() + kMost);
  const auto ratios = Double4Array<kVectors>::of(
      [&](int i) { return pivots[i] > smallest ? gain[i] * inverses[i] : Double4{} + kNever; });
  const int column = place(ratios, least(ratios));
  if (column >= rows_) return false;
  pivot<kVectors>(line, column, inverses[column / kDouble4Lanes][column % kDouble4Lanes]);
  return true;
}

template <int kVectors>
void IncrementalMatrixGame::solve_in() {
  const int limit = 4 * (rows_ + columns_);  // rounding may cycle; the current weights are then used
  for (int step = 0; step < limit; ++step) {
    if (!restore<kVectors>() && !improve<kVectors>()) break;
  }
}

void IncrementalMatrixGame::solve() { wide_ ? solve_in<2>() : solve_in<1>(); }

void IncrementalMatrixGame::solve_afresh() {
  begin();
  solve();
}

IncrementalMatrixGame::Numbers IncrementalMatrixGame::weights_of(int first,
                                                                 const std::array<double, 2 * kMost>& by_seat,
                                                                 double sign) const {
  const auto weight = [&](int i) { return larger(0.0, sign * by_seat[index(position_[index(first + i)])]); };
  const Double4Array<2> weights{{Double4{weight(0), weight(1), weight(2), weight(3)},
                                 wide_ ? Double4{weight(4), weight(5), weight(6), weight(7)} : Double4{}}};
  const double inverse = 1 / sum(weights);
  Numbers out;
  if (inverse > 0 && inverse < kNever) {
    (inverse * weights).store(out.data());
  } else {
    SingleLaneMask<2>(0).with(Double4Array<2>::all(0), 1).store(out.data());
  }
  return out;
}

IncrementalMatrixGame::Numbers IncrementalMatrixGame::row_weights() const { return weights_of(0, level_, 1); }
IncrementalMatrixGame::Numbers IncrementalMatrixGame::column_weights() const { return weights_of(kMost, gain_, -1); }

}  // namespace plannercheck
