#include "growing_game.hpp"

#include <array>
#include <cstring>
#include <utility>

#include "quads.hpp"
#include "vec.hpp"

namespace plannercheck {
namespace {

// Levels and gains are of the order of 1: what lies nearer to 0 is rounding.
constexpr double kNoise = 1e-14;
// A pivot so much smaller than others of its column is what rounding left of 0.
constexpr double kSmallestPivot = 1e-11;
constexpr double kNever = __builtin_inf();

// Eight numbers; as two quads.
struct Eight {
  Quad low, high;

  explicit Eight(const double* from) : low(load_quad(from)), high(load_quad(from + kQuad)) {}
  Eight(Quad low_quad, Quad high_quad) : low(low_quad), high(high_quad) {}
  void store(double* to) const { store_quad(to, low), store_quad(to + kQuad, high); }
};

// All bits of one of eight places.
struct Place {
  QuadMask low, high;

  explicit Place(std::size_t k) {
    // Sixteen numbers of which one is set, read from where it comes to the place.
    static constexpr std::array<long long, 16> kOne{0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0};
    std::memcpy(&low, kOne.data() + 8 - k, sizeof low);
    std::memcpy(&high, kOne.data() + 12 - k, sizeof high);
  }
  // The numbers, with another one at the place.
  Eight with(const Eight& e, double value) const {
    const Quad other = Quad{} + value;
    return {low ? other : e.low, high ? other : e.high};
  }
  // The numbers, with a number added at the place.
  Eight plus(const Eight& e, double value) const {
    const Quad zero{}, other = Quad{} + value;
    return {e.low + (low ? other : zero), e.high + (high ? other : zero)};
  }
};

unsigned bits(QuadMask low, QuadMask high) { return quad_bits(low) | quad_bits(high) << kQuad; }

double sum(const Eight& e) {
  const Quad four = e.low + e.high;
  return (four[0] + four[1]) + (four[2] + four[3]);
}

double most(const Eight& e) { return largest(e.low > e.high ? e.low : e.high); }
double least(const Eight& e) { return -most({-e.low, -e.high}); }

// The first place of a value that is there.
int place(const Eight& e, double value) {
  const unsigned found = bits(e.low == Quad{} + value, e.high == Quad{} + value);
  return found != 0 ? __builtin_ctz(found) : 0;
}

}  // namespace

void GrowingGame::fill_free(int at, int row) {
  const Line& a = payoff_[index(row)];
  Line line{};
  double gain = 1;
  for (int j = 0; j < columns_; ++j) {
    const Seat seat = seat_of_column(j);
    if (seat.basic) {
      line[index(seat.at)] += a[index(j)];
      continue;
    }
    for (int i = 0; i < columns_; ++i) line[index(i)] += a[index(j)] * tableau_[index(i)][index(seat.at)];
    gain += a[index(j)] * gain_[index(seat.at)];
  }
  const Place place(index(at));
  for (std::size_t i = 0; i < index(columns_); ++i) {
    double* const other = tableau_[i].data();
    place.with(Eight(other), line[i]).store(other);
  }
  place.with(Eight(gain_.data()), gain).store(gain_.data());
}

void GrowingGame::fill_basic(int at, int column) {
  Eight line(Quad{}, Quad{});
  double level = 1;
  for (int i = 0; i < rows_; ++i) {
    const Seat seat = seat_of_row(i);
    const double a = payoff_[index(i)][index(column)];
    if (!seat.basic) {
      line = Place(index(seat.at)).plus(line, a);
      continue;
    }
    const Eight other(tableau_[index(seat.at)].data());
    line.low -= a * other.low, line.high -= a * other.high;
    level -= a * level_[index(seat.at)];
  }
  line.store(tableau_[index(at)].data());
  Place(index(at)).with(Eight(level_.data()), level).store(level_.data());
}

// Of the rows without weight the one that would lower the optimum most.
int GrowingGame::weightless_row() const {
  int worst = -1;
  for (int i = 0; i < rows_; ++i) {
    const Seat seat = seat_of_row(i);
    if (seat.basic) continue;
    if (worst < 0 || gain_[index(seat.at)] < gain_[index(seat_of_row(worst).at)]) worst = i;
  }
  return worst < 0 ? 0 : worst;
}

// Of the columns without weight the one with most slack.
int GrowingGame::weightless_column() const {
  int loosest = -1;
  for (int j = 0; j < columns_; ++j) {
    const Seat seat = seat_of_column(j);
    if (!seat.basic) continue;
    if (loosest < 0 || level_[index(seat.at)] > level_[index(seat_of_column(loosest).at)]) loosest = j;
  }
  return loosest < 0 ? 0 : loosest;
}

void GrowingGame::put_row(int place, const Numbers& payoffs) {
  for (int j = 0; j < columns_; ++j) payoff_[index(place)][index(j)] = 1 + unit_ * payoffs[index(j)];
  if (place == rows_) {
    seat_[index(place)] = {false, rows_};
    free_[index(rows_++)] = place;
  }
  const Seat seat = seat_of_row(place);
  if (seat.basic) return begin();  // degenerate: all have weight
  fill_free(seat.at, place);
}

void GrowingGame::put_column(int place, const Numbers& payoffs) {
  for (int i = 0; i < rows_; ++i) payoff_[index(i)][index(place)] = 1 + unit_ * payoffs[index(i)];
  if (place == columns_) {
    seat_[index(kMost + place)] = {true, columns_};
    basic_[index(columns_++)] = kMost + place;
  }
  const Seat seat = seat_of_column(place);
  if (!seat.basic) return begin();
  fill_basic(seat.at, place);
}

void GrowingGame::begin() {
  for (auto& line : tableau_) line.fill(0);
  for (int i = 0; i < rows_; ++i) seat_[index(i)] = {false, i}, free_[index(i)] = i, gain_[index(i)] = 1;
  for (int j = 0; j < columns_; ++j) {
    seat_[index(kMost + j)] = {true, j}, basic_[index(j)] = kMost + j, level_[index(j)] = 1;
    for (int i = 0; i < rows_; ++i) tableau_[index(j)][index(i)] = payoff_[index(i)][index(j)];
  }
}

// The line that bounds a free variable first; among equals, which flat stars have, the one with the largest pivot.
int GrowingGame::leaving(int column) const {
  const auto k = index(column);
  const auto& t = tableau_;
  const Eight pivots(Quad{t[0][k], t[1][k], t[2][k], t[3][k]}, Quad{t[4][k], t[5][k], t[6][k], t[7][k]});
  const double smallest = kSmallestPivot * most(pivots);
  if (!(smallest > 0)) return -1;
  const Eight level(level_.data());
  const Quad never = Quad{} + kNever;
  const Eight ratios(pivots.low > smallest ? level.low / pivots.low : never,
                     pivots.high > smallest ? level.high / pivots.high : never);
  const Quad first = Quad{} + least(ratios);
  unsigned equals = bits(ratios.low == first, ratios.high == first);
  int best = __builtin_ctz(equals | 1U << kMost);
  for (equals &= equals - 1; equals != 0; equals &= equals - 1) {
    const int other = __builtin_ctz(equals);
    if (t[index(other)][k] > t[index(best)][k]) best = other;
  }
  return best;
}

// The free variable that mends a negative line at the least cost.
int GrowingGame::entering(int line) const {
  const Eight pivots(tableau_[index(line)].data()), gain(gain_.data());
  const double smallest = kSmallestPivot * -least(pivots);
  if (!(smallest > 0)) return -1;
  const Quad never = Quad{} + kNever;
  const Eight ratios(pivots.low < -smallest ? gain.low / pivots.low : never,
                     pivots.high < -smallest ? gain.high / pivots.high : never);
  return place(ratios, least(ratios));
}

void GrowingGame::pivot(int line, int column) {
  const Place by_column(index(column)), by_line(index(line));
  const std::size_t k = index(column);
  const double inverse = 1 / tableau_[index(line)][k];
  const Eight old = by_column.with(Eight(tableau_[index(line)].data()), 1);
  const Eight scaled(old.low * inverse, old.high * inverse);
  const auto reduced = [&](const Line& other) {
    const double factor = other[k];
    const Eight numbers = by_column.with(Eight(other.data()), 0);
    return Eight(numbers.low - factor * scaled.low, numbers.high - factor * scaled.high);
  };
  const auto& t = tableau_;
  const Quad low{t[0][k], t[1][k], t[2][k], t[3][k]}, high{t[4][k], t[5][k], t[6][k], t[7][k]};
  const double level = level_[index(line)] * inverse;
  const Eight levels(level_.data());
  by_line.with({levels.low - level * low, levels.high - level * high}, level).store(level_.data());
  for (std::size_t i = 0; i < index(columns_); ++i) reduced(tableau_[i]).store(tableau_[i].data());
  scaled.store(tableau_[index(line)].data());
  reduced(gain_).store(gain_.data());
  std::swap(basic_[index(line)], free_[k]);
  seat_[index(basic_[index(line)])] = {true, line};
  seat_[index(free_[k])] = {false, column};
}

// A step of the primal simplex; false at the optimum.
bool GrowingGame::improve() {
  const Eight gain(gain_.data());
  const double best = most(gain);
  if (!(best > kNoise)) return false;
  const int column = place(gain, best), line = leaving(column);
  if (line < 0 || line >= columns_) return false;
  pivot(line, column);
  return true;
}

// A step of the dual simplex; false where no level is negative.
bool GrowingGame::restore() {
  const Eight level(level_.data());
  const double worst = least(level);
  if (!(worst < -kNoise)) return false;
  const int line = place(level, worst), column = entering(line);
  if (column < 0 || column >= rows_) return false;
  pivot(line, column);
  return true;
}

void GrowingGame::solve() {
  const int limit = 4 * (rows_ + columns_);  // rounding may cycle; the weights so far are then used
  for (int step = 0; step < limit; ++step) {
    if (!restore() && !improve()) break;
  }
  total_ = sum(Eight(basic_rows().data()));
}

void GrowingGame::solve_afresh() {
  begin();
  solve();
}

GrowingGame::Numbers GrowingGame::basic_rows() const {
  const auto weight = [&](int i) {
    const Seat seat = seat_of_row(i);
    return seat.basic ? larger(0.0, level_[index(seat.at)]) : 0.0;
  };
  Numbers out;
  store_quad(out.data(), Quad{weight(0), weight(1), weight(2), weight(3)});
  store_quad(out.data() + kQuad, Quad{weight(4), weight(5), weight(6), weight(7)});
  return out;
}

GrowingGame::Numbers GrowingGame::normalised(const Numbers& weights) {
  const Eight given(weights.data());
  const double total = sum(given);
  Numbers out;
  if (total > 0 && total < kNever) {
    Eight(given.low / total, given.high / total).store(out.data());
  } else {
    Place(0).with(Eight(Quad{}, Quad{}), 1).store(out.data());
  }
  return out;
}

GrowingGame::Numbers GrowingGame::row_weights() const { return normalised(basic_rows()); }

GrowingGame::Numbers GrowingGame::column_weights() const {
  const auto weight = [&](int j) {
    const Seat seat = seat_of_column(j);
    return seat.basic ? 0.0 : larger(0.0, -gain_[index(seat.at)]);
  };
  Numbers out;
  store_quad(out.data(), Quad{weight(0), weight(1), weight(2), weight(3)});
  store_quad(out.data() + kQuad, Quad{weight(4), weight(5), weight(6), weight(7)});
  return normalised(out);
}

}  // namespace plannercheck
