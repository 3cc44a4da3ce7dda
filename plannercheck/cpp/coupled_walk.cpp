// The coupled walk, section "Detecting intersections in 3D" of the paper, with the polars hidden in the game:
//
//   separation invariant          q in conv(Q_j) with q·p > 1 for all vertices p of P_i, least at v
//   inverse separation invariant  x in P_i with q·x <= 1 for all vertices q of Q_j, largest at k
//   star invariant, primal        q_phi in conv(Q_j) with q_phi·p > 1 for all vertices p of P_i but p*
//   star invariant, polar         x_gamma in P_i with q·x_gamma <= 1 for all vertices q of Q_j but q*
//
// P_i and Q_j are the levels of the two inner hierarchies that the walk has come to. P* is p* with its neighbours
// (bounded degree, as p* was removed), Q* likewise; at the top they are all of the top. Each round goes down in one of
// the hierarchies; the cone tests of Cases 2.1 and 2.2 are one game of P* against Q* and a closed form.
//
// Departures from the text: Case 1 sets no P* or p* (they would be overwritten before use), several levels without a
// vertex beyond the plane are passed at once, and where the plane through v passes beyond a vertex p that it still
// separates (1 < q·p < q·v), v moves to p without a game.
#include <algorithm>
#include <vector>

#include "game.hpp"
#include "solvers.hpp"

namespace plannercheck {
namespace {

// P* or Q*: the star of a vertex, and the point of the star invariant.
struct Star {
  int count = 0;
  std::array<Vec3, kTopVertices + 1> point;

  void add(Vec3 p) { point[static_cast<std::size_t>(count++)] = p; }
};

constexpr int kDirectGame = kMaxActives;  // up to this many points a side the game is solved as it stands

class CoupledWalk {
 public:
  CoupledWalk(const PairFrame& frame, PairCounters& counters)
      : frame_(frame), p_(frame.guest().inner), q_(frame.host().polar), counters_(counters) {}

  Certificate run() {
    for (const std::int32_t v : unpadded(p_.top)) guest_star_.add(frame_.guest_vertex(v));
    for (const std::int32_t k : unpadded(q_.top)) host_star_.add(frame_.polar_point(k));
    bool separated = play();
    if (separated) {
      plane_ = played_plane_;
      guest_tip_ = extreme_at_top(p_, frame_.guest_direction(plane_), counters_.queries);
    } else {
      point_ = played_point_;
      host_tip_ = extreme_at_top(q_, point_, counters_.queries);
    }
    while (step_ == Step::kOn) separated = separated ? walk_primal() : walk_polar();
    return certificate(separated);
  }

 private:
  enum class Step { kOn, kBottom };

  const PairFrame& frame_;
  const Hierarchy& p_;
  const Hierarchy& q_;
  PairCounters& counters_;
  Step step_ = Step::kOn;
  long mixtures_ = 0;            // games so far: how deep the points of the invariants are mixed, at most
  Star guest_star_, host_star_;  // P*, Q*
  std::int32_t guest_tip_ = -1, host_tip_ = -1;  // v and k, where the plane and the point are tangent
  Vec3 plane_, point_;                           // q and x of the invariant that holds
  std::int32_t p_star_ = -1, q_star_ = -1;       // p*, q*; −1 while that hierarchy is at its top
  Vec3 q_phi_, x_gamma_;
  Vec3 played_plane_, played_point_;  // what the last game found

  static std::vector<std::int32_t> unpadded(const std::vector<std::int32_t>& top) {
    std::vector<std::int32_t> ids(top);
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
  }

  // The separation invariant holds: one or more levels down in the hierarchy of P. Returns whether it still holds.
  bool walk_primal() {
    ++counters_.rounds;
    const std::int32_t p = next_beyond(p_, guest_tip_, frame_.guest_direction(plane_), counters_.queries);
    if (p < 0) {
      step_ = Step::kBottom;
      return true;
    }
    guest_tip_ = p;
    const Vec3 tip = frame_.guest_vertex(p);
    if (dot(plane_, tip) > 1) return true;  // the plane, moved to p, still separates
    p_star_ = p;
    q_phi_ = plane_;
    take_star(p_, p, guest_star_, [&](std::int32_t n) { return frame_.guest_vertex(n); });
    if (play()) {  // Case 2.1
      plane_ = towards(plane_, played_plane_, guest_star_, -1);
      return true;
    }
    point_ = played_point_;  // Case 2.2
    if (q_star_ < 0) {
      host_tip_ = extreme_at_top(q_, point_, counters_.queries);
    } else {
      point_ = towards(x_gamma_, played_point_, host_star_, +1);
      host_tip_ = q_star_;
      guest_star_.add(x_gamma_);
    }
    return false;
  }

  // The inverse separation invariant holds: the same with the roles of P and Q swapped.
  bool walk_polar() {
    ++counters_.rounds;
    const std::int32_t k = next_beyond(q_, host_tip_, point_, counters_.queries);
    if (k < 0) {
      step_ = Step::kBottom;
      return false;
    }
    host_tip_ = k;
    const Vec3 tip = frame_.polar_point(k);
    if (dot(tip, point_) <= 1) return false;
    q_star_ = k;
    x_gamma_ = point_;
    take_star(q_, k, host_star_, [&](std::int32_t n) { return frame_.polar_point(n); });
    if (!play()) {  // Case 2.1
      point_ = towards(point_, played_point_, host_star_, +1);
      return false;
    }
    plane_ = played_plane_;  // Case 2.2
    if (p_star_ < 0) {
      guest_tip_ = extreme_at_top(p_, frame_.guest_direction(plane_), counters_.queries);
    } else {
      plane_ = towards(q_phi_, played_plane_, guest_star_, -1);
      guest_tip_ = p_star_;
      host_star_.add(q_phi_);
    }
    return true;
  }

  template <class Point>
  static void take_star(const Hierarchy& h, std::int32_t v, Star& star, Point point) {
    star.count = 0;
    star.add(point(v));
    const auto k = static_cast<std::size_t>(v);
    for (std::int32_t i = h.ring_start[k]; i < h.ring_start[k + 1]; ++i)
      star.add(point(h.rings[static_cast<std::size_t>(i)]));
  }

  // The point of the segment from `from`, which satisfies the invariant but at the star's tip, to `to`, which satisfies
  // it on the star: past the parameter where the tip passes 1, as far as the tip remains the star's extreme point
  // (sense +1: largest, −1: least). By convexity it is then extreme on the whole level.
  static Vec3 towards(Vec3 from, Vec3 to, const Star& star, int sense) {
    const Vec3 tip = star.point[0];
    double t = 1;
    for (int i = 1; i < star.count; ++i) {
      const Vec3 edge = static_cast<double>(sense) * (tip - star.point[static_cast<std::size_t>(i)]);
      const double start = dot(from, edge), end = dot(to, edge);
      if (end < 0) t = smaller(t, start > 0 ? start / (start - end) : 0.0);
    }
    const double at_start = dot(from, tip), at_end = dot(to, tip);
    const double needed = at_end != at_start ? (1 - at_start) / (at_end - at_start) : 1.0;
    t = std::clamp(larger(t, needed), 0.0, 1.0);
    return (1 - t) * from + t * to;
  }

  // Plays P* against Q*: whether conv(P*) is separated from the polar of Q*; sets the played plane or point.
  bool play() {
    ++counters_.games, ++mixtures_;
    return guest_star_.count <= kDirectGame && host_star_.count <= kDirectGame ? play_directly() : play_by_oracles();
  }

  bool play_directly() {
    Game game;
    Mixture mixture;
    game.rows = guest_star_.count;
    game.columns = host_star_.count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(game.rows); ++i) {
      for (std::size_t j = 0; j < static_cast<std::size_t>(game.columns); ++j) {
        game.payoff[i][j] = dot(guest_star_.point[i], host_star_.point[j]);
      }
    }
    solve(game, mixture);
    played_plane_ = played_point_ = {};
    for (std::size_t j = 0; j < static_cast<std::size_t>(game.columns); ++j) {
      played_plane_ = played_plane_ + mixture.column[j] * host_star_.point[j];
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(game.rows); ++i) {
      played_point_ = played_point_ + mixture.row[i] * guest_star_.point[i];
    }
    return mixture.value > 1;
  }

  // The same for a star that is a whole top: active subsets, extended by scans.
  bool play_by_oracles() {
    Star rows, columns;
    rows.add(guest_star_.point[0]);
    columns.add(host_star_.point[furthest(host_star_, rows.point[0])]);
    for (;;) {
      Star all_rows = rows, all_columns = columns;
      std::swap(all_rows, guest_star_), std::swap(all_columns, host_star_);
      const bool separated = play_directly();
      std::swap(all_rows, guest_star_), std::swap(all_columns, host_star_);
      const Vec3 found = separated ? guest_star_.point[furthest(guest_star_, -played_plane_)]
                                   : host_star_.point[furthest(host_star_, played_point_)];
      Star& side = separated ? rows : columns;
      const bool known =
          std::find(side.point.begin(), side.point.begin() + side.count, found) != side.point.begin() + side.count;
      const bool settled = separated ? dot(played_plane_, found) > 1 : dot(played_point_, found) <= 1;
      if (known || settled || side.count == kDirectGame) return separated;
      side.add(found);
    }
  }

  static std::size_t furthest(const Star& star, Vec3 u) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < static_cast<std::size_t>(star.count); ++i) {
      if (dot(u, star.point[i]) > dot(u, star.point[best])) best = i;
    }
    return best;
  }

  // The bottom is reached: the invariant that holds is the answer, checked by one query over the whole body.
  Certificate certificate(bool separated) {
    Certificate certificate;
    certificate.q = plane_;
    certificate.x = point_;
    certificate.mixtures = mixtures_;
    if (separated) {
      ++counters_.guest_queries;
      const std::int32_t v = extreme(p_, frame_.guest_direction(plane_), counters_.queries);
      const double value = dot(plane_, frame_.guest_vertex(v));
      if (frame_.separates(plane_, value, mixtures_)) certificate.answer = Answer::kSeparated;
    } else {
      ++counters_.host_queries;
      const std::int32_t k = extreme(q_, point_, counters_.queries);
      if (frame_.contains(dot(frame_.polar_point(k), point_), mixtures_)) certificate.answer = Answer::kShared;
    }
    return certificate;
  }
};

}  // namespace

Certificate coupled_walk(const PairFrame& frame, PairCounters& counters) { return CoupledWalk(frame, counters).run(); }

}  // namespace plannercheck
