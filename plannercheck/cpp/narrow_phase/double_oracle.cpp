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

  // Starts from A's vertex and B's facet that a point of A violates most.
  void start(std::int32_t vertex, std::int32_t facet) {
    add_row(vertex, frame_.vertex_a(vertex));
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
  Actives rows_, columns_;                     // vertices of A, points of B's polar
  std::optional<IncrementalMatrixGame> game_;  // most searches end before they need it
  bool afresh_ = false;                        // solved from the beginning since the last vertex or facet was added
  Certificate certificate_;

  // An upper bound of |q·x| over B's polar and A, with room for rounding.
  static double largest_payoff(const PairFrame& frame) {
    return 1.001 * frame.body_b().polar_radius * (norm(frame.centre_a()) + frame.body_a().radius) + 1e-300;
  }

  // Games of up to two vertices and two facets have a closed form, which is used unless it made no progress.
  bool opening() const { return columns_.count <= 2 && rows_.count <= 2 && !afresh_; }

  bool ask_next() {
    if (rows_.count == 1) return ask_a(columns_.point(0));
    if (columns_.count == 1) return ask_b(rows_.point(1));  // it is lower than the first vertex
    return ask_by_two();
  }

  // Two vertices against two facets. The first facet answered to the first vertex, so a >= b; the second vertex to that
  // facet, so a >= c; the second facet to that vertex, so d >= c. If also d > b, both sides mix; else d is the value.
  bool ask_by_two() {
    const Vec3 x0 = rows_.point(0), x1 = rows_.point(1), q0 = columns_.point(0), q1 = columns_.point(1);
    const double a = dot(x0, q0), b = dot(x0, q1), c = dot(x1, q0), d = dot(x1, q1);
    if (!(d > b && a > b && d > c && a > c)) return ask_a(q1);
    if (a * d - b * c > (a - b) + (d - c)) {
      const double sum = (d - b) + (a - c);
      return ask_a((d - b) / sum * q0 + (a - c) / sum * q1);
    }
    const double sum = (d - c) + (a - b);
    return ask_b((d - c) / sum * x0 + (a - b) / sum * x1);
  }

  bool ask_by_game() {
    ++counters_.games;
    if (!game_) begin_game();
    game_->solve();
    return game_->is_above_one() ? ask_a(columns_.mixed(game_->column_weights()))
                                 : ask_b(rows_.mixed(game_->row_weights()));
  }

  void begin_game() {
    IncrementalMatrixGame::Payoffs by_row, by_column;
    for (std::size_t i = 0; i < at(rows_.count); ++i) by_row[i] = columns_.products(rows_.point(i));
    for (std::size_t j = 0; j < at(columns_.count); ++j) by_column[j] = rows_.products(columns_.point(j));
    game_.emplace(largest_payoff(frame_), rows_.count, columns_.count, by_row, by_column);
  }

  // Looks for A's vertex deepest below the plane q; true if it ends the search.
  bool ask_a(Vec3 q) {
    ++counters_.queries_a;
    const std::int32_t v = extreme(frame_.body_a().inner, frame_.direction_a(q), counters_.queries);
    const Vec3 x = frame_.vertex_a(v);
    certificate_.q = q;
    if (frame_.separates(q, dot(q, x))) {
      certificate_.answer = Answer::kSeparated;
      return true;
    }
    if (rows_.holds(v)) return no_progress();
    add_row(v, x);
    return false;
  }

  // Looks for B's facet that x violates most; true if it ends the search.
  bool ask_b(Vec3 x) {
    ++counters_.queries_b;
    const std::int32_t k = extreme(frame_.body_b().polar, x, counters_.queries);
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

// Where the search begins. Most bodies that overlap deeply share, approximately, A's point that reaches
// furthest towards B's centre. So B is queried for that point before anything else is set up.
Vec3 first_point(const PairFrame& frame, std::int32_t vertex_a) {
  return frame.body_a().is_box != 0 ? frame.box_point_a() : frame.vertex_a(vertex_a);
}

Certificate shared_at(Vec3 x) {
  Certificate certificate;
  certificate.answer = Answer::kShared;
  certificate.x = x;
  return certificate;
}

}  // namespace

std::optional<Certificate> double_oracle(const PairFrame& frame, std::int32_t vertex_a, PairCounters& counters) {
  const Vec3 x = first_point(frame, vertex_a);
  ++counters.queries_b;
  const std::int32_t k = extreme(frame.body_b().polar, x, counters.queries);
  if (bodies_hold(frame, x, dot(frame.polar_point(k), x), 0, counters)) return shared_at(x);
  DoubleOracle oracle(frame, counters);
  oracle.start(vertex_a, k);
  int rounds = 1;
  bool has_ended = oracle.round();
  for (; !has_ended && rounds < kOracleRounds; ++rounds) has_ended = oracle.round();
  return has_ended ? std::optional(oracle.certificate()) : std::nullopt;
}

}  // namespace plannercheck
