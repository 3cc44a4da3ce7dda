#include "narrow_phase/double_oracle.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "math/double4.hpp"
#include "narrow_phase/depth_past_dents.hpp"
#include "narrow_phase/incremental_matrix_game.hpp"

namespace plannercheck {
namespace {

// Active sets that keep only the support cycle near contact (measured: 5 to 12 %).
constexpr int kActives = IncrementalMatrixGame::kMost;
// GJK needs fewer at 100,000 vertices.
constexpr int kOracleRounds = 48;

// Unused places hold zeros.
struct Actives {
  int count = 0;
  std::array<std::int32_t, kActives> id;
  IncrementalMatrixGame::Numbers x{}, y{}, z{};

  bool holds(std::int32_t vertex) const {
    return std::find(id.begin(), id.begin() + count, vertex) != id.begin() + count;
  }

  void put(int place, std::int32_t vertex, Vec3 p) {
    id[at(place)] = vertex;
    x[at(place)] = p.x, y[at(place)] = p.y, z[at(place)] = p.z;
    count = std::max(count, place + 1);
  }

  Vec3 point(std::size_t i) const { return {x[i], y[i], z[i]}; }

  Vec3 mixed(const IncrementalMatrixGame::Numbers& weights) const {
    const auto sum = [&](const IncrementalMatrixGame::Numbers& n) {
      Double4 four{};
      for (std::size_t i = 0; i < kActives; i += kDouble4Lanes) four += load_double4(&weights[i]) * load_double4(&n[i]);
      return (four[0] + four[1]) + (four[2] + four[3]);
    };
    return {sum(x), sum(y), sum(z)};
  }

  IncrementalMatrixGame::Numbers products(Vec3 p) const {
    IncrementalMatrixGame::Numbers out;
    for (std::size_t i = 0; i < kActives; i += kDouble4Lanes) {
      store_double4(&out[i], load_double4(&x[i]) * p.x + load_double4(&y[i]) * p.y + load_double4(&z[i]) * p.z);
    }
    return out;
  }
};

class DoubleOracle {
 public:
  DoubleOracle(const PairFrame& frame, PairCounters& counters) : frame_(frame), counters_(counters) {}

  const Certificate& certificate() const { return certificate_; }

  // Starts from a guest's vertex and the host's facet that a point of the guest violates most.
  void start(std::int32_t vertex, std::int32_t facet) {
    add_row(vertex, frame_.guest_vertex(vertex));
    add_column(facet, frame_.polar_point(facet));
  }

  // Asks for one more vertex or facet; true if the search is over.
  bool round() {
    ++counters_.rounds;
    return opening() ? ask_next() : ask_by_game();
  }

 private:
  const PairFrame& frame_;
  PairCounters& counters_;
  Actives rows_, columns_;                     // vertices of the guest, points of the host's polar
  std::optional<IncrementalMatrixGame> game_;  // most searches end before they need it
  bool afresh_ = false;                        // solved from the beginning since the last vertex or facet was added
  Certificate certificate_;

  // An upper bound of |q·x| over the host's polar and the guest, with room for rounding.
  static double largest_payoff(const PairFrame& frame) {
    return 1.001 * frame.host().polar_radius * (norm(frame.guest_centre()) + frame.guest().radius) + 1e-300;
  }

  // Games of up to two vertices and two facets have a closed form, which is used unless it made no progress.
  bool opening() const { return columns_.count <= 2 && rows_.count <= 2 && !afresh_; }

  bool ask_next() {
    if (rows_.count == 1) return ask_guest(columns_.point(0));
    if (columns_.count == 1) return ask_host(rows_.point(1));  // it is lower than the first vertex
    return ask_by_two();
  }

  // Two vertices against two facets. The first facet answered to the first vertex, so a >= b; the second vertex to that
  // facet, so a >= c; the second facet to that vertex, so d >= c. If also d > b, both sides mix; else d is the value.
  bool ask_by_two() {
    const Vec3 x0 = rows_.point(0), x1 = rows_.point(1), q0 = columns_.point(0), q1 = columns_.point(1);
    const double a = dot(x0, q0), b = dot(x0, q1), c = dot(x1, q0), d = dot(x1, q1);
    if (!(d > b && a > b && d > c && a > c)) return ask_guest(q1);
    if (a * d - b * c > (a - b) + (d - c)) {
      const double sum = (d - b) + (a - c);
      return ask_guest((d - b) / sum * q0 + (a - c) / sum * q1);
    }
    const double sum = (d - c) + (a - b);
    return ask_host((d - c) / sum * x0 + (a - b) / sum * x1);
  }

  bool ask_by_game() {
    ++counters_.games;
    if (!game_) begin_game();
    game_->solve();
    return game_->is_above_one() ? ask_guest(columns_.mixed(game_->column_weights()))
                                 : ask_host(rows_.mixed(game_->row_weights()));
  }

  void begin_game() {
    IncrementalMatrixGame::Payoffs by_row, by_column;
    for (std::size_t i = 0; i < at(rows_.count); ++i) by_row[i] = columns_.products(rows_.point(i));
    for (std::size_t j = 0; j < at(columns_.count); ++j) by_column[j] = rows_.products(columns_.point(j));
    game_.emplace(largest_payoff(frame_), rows_.count, columns_.count, by_row, by_column);
  }

  // Looks for the guest's vertex deepest below the plane q; true if it ends the search.
  bool ask_guest(Vec3 q) {
    ++counters_.guest_queries;
    const std::int32_t v = extreme(frame_.guest().inner, frame_.guest_direction(q), counters_.queries);
    const Vec3 x = frame_.guest_vertex(v);
    certificate_.q = q;
    if (frame_.separates(q, dot(q, x))) {
      certificate_.answer = Answer::kSeparated;
      return true;
    }
    if (rows_.holds(v)) return no_progress();
    add_row(v, x);
    return false;
  }

  // Looks for the host's facet that x violates most; true if it ends the search.
  bool ask_host(Vec3 x) {
    ++counters_.host_queries;
    const std::int32_t k = extreme(frame_.host().polar, x, counters_.queries);
    const Vec3 q = frame_.polar_point(k);
    certificate_.x = x;
    if (bodies_hold(frame_, x, dot(q, x), 0, counters_)) {
      certificate_.answer = Answer::kShared;
      return true;
    }
    if (columns_.holds(k)) return no_progress();
    add_column(k, q);
    return false;
  }

  // Either the game's rounding has grown, or the bodies are too close for doubles.
  bool no_progress() {
    if (afresh_) return true;
    afresh_ = true;
    if (game_) game_->solve_afresh();
    return false;
  }

  void add_row(std::int32_t vertex, Vec3 x) {
    const int place = game_ ? game_->place_of_row() : rows_.count;
    rows_.put(place, vertex, x);
    if (game_) game_->put_row(place, columns_.products(x));
    afresh_ = false;
  }

  void add_column(std::int32_t k, Vec3 q) {
    const int place = game_ ? game_->place_of_column() : columns_.count;
    columns_.put(place, k, q);
    if (game_) game_->put_column(place, rows_.products(q));
    afresh_ = false;
  }
};

// Where the search begins. Most bodies that overlap deeply share, approximately, the guest's point that reaches
// furthest towards the host's centre. So the host is queried for that point before anything else is set up.
Vec3 first_point(const PairFrame& frame, std::int32_t guest_vertex) {
  return frame.guest().is_box != 0 ? frame.guest_box_point() : frame.guest_vertex(guest_vertex);
}

Certificate shared_at(Vec3 x) {
  Certificate certificate;
  certificate.answer = Answer::kShared;
  certificate.x = x;
  return certificate;
}

}  // namespace

std::optional<Certificate> double_oracle(const PairFrame& frame, std::int32_t guest_vertex, PairCounters& counters) {
  const Vec3 x = first_point(frame, guest_vertex);
  ++counters.host_queries;
  const std::int32_t k = extreme(frame.host().polar, x, counters.queries);
  if (bodies_hold(frame, x, dot(frame.polar_point(k), x), 0, counters)) return shared_at(x);
  DoubleOracle oracle(frame, counters);
  oracle.start(guest_vertex, k);
  int rounds = 1;
  bool has_ended = oracle.round();
  for (; !has_ended && rounds < kOracleRounds; ++rounds) has_ended = oracle.round();
  return has_ended ? std::optional(oracle.certificate()) : std::nullopt;
}

}  // namespace plannercheck
