#include "narrow_phase/coupled_walk.hpp"

#include <algorithm>

#include "narrow_phase/depth_past_dents.hpp"
#include "narrow_phase/matrix_game.hpp"

namespace plannercheck {
namespace {

// P* or Q*: the star of a vertex, and the point of the star invariant.
struct Star {
  int count = 0;
  std::array<Vec3, kMaxActives> point;

  void add(Vec3 p) { point[static_cast<std::size_t>(count++)] = p; }
};

// Share of the segment on which the tip is extreme that is used. At its end the tip ties with a neighbour, rounding
// would pick either, and the closing check would fail half the time. Measured: 0.5 to 0.99 take equal work.
constexpr double kPassage = 0.9;

static_assert(kHighestTop <= kMaxActives && 1 + kRemovedDegree + 1 <= kMaxActives, "every star fits a game");

class CoupledWalk {
 public:
  CoupledWalk(const PairFrame& frame, PairCounters& counters)
      : frame_(frame), p_(frame.body_a().inner), q_(frame.body_b().polar), counters_(counters) {}

  Certificate run() {
    take_highest_top(p_, star_a_, [&](std::int32_t v) { return frame_.vertex_a(v); });
    take_highest_top(q_, star_b_, [&](std::int32_t k) { return frame_.polar_point(k); });
    bool separated = play();
    if (separated) {
      plane_ = played_plane_;
      tip_a_ = extreme_at_highest_top(p_, frame_.direction_a(plane_));
    } else {
      point_ = played_point_;
      tip_b_ = extreme_at_highest_top(q_, point_);
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
  long mixtures_ = 0;                     // games so far: bounds how often the points of the invariants are mixed again
  Star star_a_, star_b_;                  // P*, Q*
  std::int32_t tip_a_ = -1, tip_b_ = -1;  // v and k, where the plane and the point are tangent
  Vec3 plane_, point_;                    // q and x of the invariant that holds
  std::int32_t p_star_ = -1, q_star_ = -1;  // p*, q*; −1 while that hierarchy is at its top
  Vec3 q_phi_, x_gamma_;
  Vec3 played_plane_, played_point_;  // what the last game found

  // The separation invariant holds: goes down one or more levels of P's hierarchy; returns whether it still holds.
  bool walk_primal() {
    ++counters_.rounds;
    const std::int32_t p = finer_beyond(p_, tip_a_, frame_.direction_a(plane_));
    if (p < 0) {
      step_ = Step::kBottom;
      return true;
    }
    tip_a_ = p;
    const Vec3 tip = frame_.vertex_a(p);
    if (dot(plane_, tip) > 1) return true;  // the plane, moved to p, still separates
    p_star_ = p;
    q_phi_ = plane_;
    take_star(p_, p, star_a_, [&](std::int32_t n) { return frame_.vertex_a(n); });
    if (play()) {  // Case 2.1
      plane_ = towards(plane_, played_plane_, star_a_, -1);
      return true;
    }
    point_ = played_point_;  // Case 2.2
    if (q_star_ < 0) {
      tip_b_ = extreme_at_highest_top(q_, point_);
    } else {
      point_ = towards(x_gamma_, played_point_, star_b_, +1);
      tip_b_ = q_star_;
      star_a_.add(x_gamma_);
    }
    return false;
  }

  // A step while the inverse separation invariant holds: the same with the roles of P and Q swapped.
  bool walk_polar() {
    ++counters_.rounds;
    const std::int32_t k = finer_beyond(q_, tip_b_, point_);
    if (k < 0) {
      step_ = Step::kBottom;
      return false;
    }
    tip_b_ = k;
    const Vec3 tip = frame_.polar_point(k);
    if (dot(tip, point_) <= 1) return false;
    q_star_ = k;
    x_gamma_ = point_;
    take_star(q_, k, star_b_, [&](std::int32_t n) { return frame_.polar_point(n); });
    if (!play()) {  // Case 2.1
      point_ = towards(point_, played_point_, star_b_, +1);
      return false;
    }
    plane_ = played_plane_;  // Case 2.2
    if (p_star_ < 0) {
      tip_a_ = extreme_at_highest_top(p_, frame_.direction_a(plane_));
    } else {
      plane_ = towards(q_phi_, played_plane_, star_a_, -1);
      tip_a_ = p_star_;
      star_b_.add(q_phi_);
    }
    return true;
  }

  // The index of a vertex among the top vertices, which is its id in the top levels; -1 below the top.
  static std::int32_t place_in_top_levels(const Hierarchy& h, std::int32_t v) {
    if (h.level[static_cast<std::size_t>(v)] < h.depth) return -1;
    return static_cast<std::int32_t>(std::lower_bound(h.top.begin(), h.top.end(), v) - h.top.begin());
  }

  static std::int32_t from_top_levels(const Hierarchy& h, std::int32_t place) {
    return place < 0 ? -1 : h.top[static_cast<std::size_t>(place)];
  }

  std::int32_t extreme_at_highest_top(const Hierarchy& h, Vec3 u) {
    return from_top_levels(h, extreme_at_top(h.top_levels, u, counters_.queries));
  }

  // As next_beyond, through the top levels and those below.
  std::int32_t finer_beyond(const Hierarchy& h, std::int32_t v, Vec3 u) {
    const std::int32_t place = place_in_top_levels(h, v);
    const std::int32_t found = place < 0 ? -1 : next_beyond(h.top_levels, place, u, counters_.queries);
    return found < 0 ? next_beyond(h, v, u, counters_.queries) : from_top_levels(h, found);
  }

  template <class Point>
  static void take_highest_top(const Hierarchy& h, Star& star, Point point) {
    std::int32_t last = -1;
    for (const std::int32_t place : h.top_levels.top) {
      if (place != last) star.add(point(from_top_levels(h, place)));  // the padding repeats the last one
      last = place;
    }
  }

  template <class Point>
  static void take_star(const Hierarchy& h, std::int32_t v, Star& star, Point point) {
    const std::int32_t place = place_in_top_levels(h, v);
    const Levels& levels = place < 0 ? h : h.top_levels;
    const auto k = static_cast<std::size_t>(place < 0 ? v : place);
    star.count = 0;
    star.add(point(v));
    for (std::int32_t i = levels.ring_start[k]; i < levels.ring_start[k + 1]; ++i) {
      const std::int32_t n = levels.rings[static_cast<std::size_t>(i)];
      star.add(point(place < 0 ? n : from_top_levels(h, n)));
    }
  }

  // A point of the segment from `from`, which satisfies the invariant except at the star's tip, to `to`, which
  // satisfies it on the star. It lies beyond the parameter where the tip passes 1, most of the way to where the tip
  // stops being the star's extreme point (sense +1: largest, −1: least). By convexity the tip is then extreme on the
  // whole level.
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
    t = std::clamp(needed + kPassage * larger(t - needed, 0.0), 0.0, 1.0);
    return (1 - t) * from + t * to;
  }

  // Plays P* against Q*. Returns whether conv(P*) is separated from the polar of Q*; sets the played plane and point.
  bool play() {
    ++counters_.games, ++mixtures_;
    Game game;
    Mixture mixture;
    game.rows = star_a_.count;
    game.columns = star_b_.count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(game.rows); ++i) {
      for (std::size_t j = 0; j < static_cast<std::size_t>(game.columns); ++j) {
        game.payoff[i][j] = dot(star_a_.point[i], star_b_.point[j]);
      }
    }
    solve(game, mixture);
    played_plane_ = played_point_ = {};
    for (std::size_t j = 0; j < static_cast<std::size_t>(game.columns); ++j) {
      played_plane_ = played_plane_ + mixture.column[j] * star_b_.point[j];
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(game.rows); ++i) {
      played_point_ = played_point_ + mixture.row[i] * star_a_.point[i];
    }
    return mixture.value > 1;
  }

  // The extreme vertex along u, where the walk has come to the bottom at `tip` and no vertex of its chain is beyond. If
  // none of its ring is beyond either, it is the tip; rounding may break that. Tips at the highest level have no ring:
  // they were found there for this u.
  std::int32_t closing(const Hierarchy& h, std::int32_t tip, Vec3 u) {
    const std::int32_t place = place_in_top_levels(h, tip);
    const std::int32_t further = place < 0
                                     ? beyond_in_ring(h, tip, u, counters_.queries)
                                     : from_top_levels(h, beyond_in_ring(h.top_levels, place, u, counters_.queries));
    return further < 0 ? tip : extreme_from(h, further, u, counters_.queries);
  }

  // At the bottom the invariant that holds is the answer; it is checked over the whole body.
  Certificate certificate(bool separated) {
    Certificate certificate;
    certificate.q = plane_;
    certificate.x = point_;
    certificate.mixtures = mixtures_;
    if (separated) {
      ++counters_.queries_a;
      const std::int32_t v = closing(p_, tip_a_, frame_.direction_a(plane_));
      const double value = dot(plane_, frame_.vertex_a(v));
      if (frame_.separates(plane_, value, mixtures_)) certificate.answer = Answer::kSeparated;
    } else {
      ++counters_.queries_b;
      const std::int32_t k = closing(q_, tip_b_, point_);
      const double value = dot(frame_.polar_point(k), point_);
      if (bodies_hold(frame_, point_, value, mixtures_, counters_)) certificate.answer = Answer::kShared;
    }
    return certificate;
  }
};

}  // namespace

Certificate coupled_walk(const PairFrame& frame, PairCounters& counters) { return CoupledWalk(frame, counters).run(); }

}  // namespace plannercheck
