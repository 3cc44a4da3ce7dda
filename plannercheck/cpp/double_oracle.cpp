#include <algorithm>

#include "game.hpp"
#include "solvers.hpp"

namespace plannercheck {
namespace {

constexpr int kActives = 8;        // keeping only the support cycles near contact (measured: 5 to 12 % of pairs)
constexpr int kOracleRounds = 48;  // GJK needs fewer at 100,000 vertices; what is left is decided exactly

struct Actives {
  int count = 0;
  std::array<std::int32_t, kActives> id;
  std::array<Vec3, kActives> point;

  bool holds(std::int32_t vertex) const {
    return std::find(id.begin(), id.begin() + count, vertex) != id.begin() + count;
  }
};

class DoubleOracle {
 public:
  DoubleOracle(const PairFrame& frame, PairCounters& counters) : frame_(frame), counters_(counters) {}

  Certificate run(std::int32_t vertex) {
    if (!start(vertex)) return certificate_;
    for (int round = 0; round < kOracleRounds; ++round) {
      ++counters_.rounds, ++counters_.games;
      solve(game_, mixture_);
      const bool done =
          mixture_.value > 1 ? ask_guest(mixed(columns_, mixture_.column)) : ask_host(mixed(rows_, mixture_.row));
      if (done) break;
    }
    return certificate_;
  }

 private:
  // Small bodies take part as a whole; else the given vertex and what the host says to it. False if that is the end.
  bool start(std::int32_t vertex) {
    const std::vector<Vec3>& polar = frame_.host().polar.points;
    const std::size_t vertices = frame_.guest().inner.points.size();
    if (polar.size() <= kActives) {
      for (std::size_t k = 0; k < polar.size(); ++k) add_column(static_cast<std::int32_t>(k), polar[k]);
    }
    if (vertices > kActives) {
      add_row(vertex, frame_.guest_vertex(vertex));
      return columns_.count > 0 || !ask_host(rows_.point[0]);
    }
    for (std::size_t v = 0; v < vertices; ++v) {
      add_row(static_cast<std::int32_t>(v), frame_.guest_vertex(static_cast<std::int32_t>(v)));
    }
    return columns_.count > 0 || !ask_host(frame_.guest_centre());
  }

  const PairFrame& frame_;
  PairCounters& counters_;
  Actives rows_, columns_;  // vertices of the guest, points of the host's polar
  Game game_;
  Mixture mixture_;
  Certificate certificate_;

  static Vec3 mixed(const Actives& actives, const std::array<double, kMaxActives>& weights) {
    Vec3 sum;
    for (int i = 0; i < actives.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      sum = sum + weights[k] * actives.point[k];
    }
    return sum;
  }

  // Looks for the guest's vertex that is deepest below the plane q; true if that ends the search.
  bool ask_guest(Vec3 q) {
    ++counters_.guest_queries;
    const std::int32_t v = extreme(frame_.guest().inner, frame_.guest_direction(q), counters_.queries);
    const Vec3 x = frame_.guest_vertex(v);
    certificate_.q = q;
    if (frame_.separates(q, dot(q, x))) {
      certificate_.answer = Answer::kSeparated;
      return true;
    }
    if (rows_.holds(v)) return true;  // no progress: too close to call
    add_row(v, x);
    return false;
  }

  // Looks for the host's facet that x violates most; true if that ends the search.
  bool ask_host(Vec3 x) {
    ++counters_.host_queries;
    const std::int32_t k = extreme(frame_.host().polar, x, counters_.queries);
    const Vec3 q = frame_.polar_point(k);
    certificate_.x = x;
    if (frame_.contains(dot(q, x))) {
      certificate_.answer = Answer::kShared;
      return true;
    }
    if (columns_.holds(k)) return true;
    add_column(k, q);
    return false;
  }

  // A free place, or that of the active with the least weight in the last game.
  static std::size_t place(Actives& actives, const std::array<double, kMaxActives>& weights) {
    if (actives.count < kActives) return static_cast<std::size_t>(actives.count++);
    return static_cast<std::size_t>(std::min_element(weights.begin(), weights.begin() + kActives) - weights.begin());
  }

  void add_row(std::int32_t vertex, Vec3 x) {
    const std::size_t i = place(rows_, mixture_.row);
    rows_.id[i] = vertex;
    rows_.point[i] = x;
    game_.rows = rows_.count;
    for (std::size_t j = 0; j < static_cast<std::size_t>(columns_.count); ++j)
      game_.payoff[i][j] = dot(columns_.point[j], x);
  }

  void add_column(std::int32_t k, Vec3 q) {
    const std::size_t j = place(columns_, mixture_.column);
    columns_.id[j] = k;
    columns_.point[j] = q;
    game_.columns = columns_.count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows_.count); ++i) game_.payoff[i][j] = dot(q, rows_.point[i]);
  }
};

}  // namespace

Certificate double_oracle(const PairFrame& frame, std::int32_t guest_vertex, PairCounters& counters) {
  return DoubleOracle(frame, counters).run(guest_vertex);
}

}  // namespace plannercheck
