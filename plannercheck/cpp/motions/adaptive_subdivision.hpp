// Adaptive subdivision of a motion, in space and in the plane: grids of states, finer where pairs are not settled.
//
// In: a run, which poses the grids and measures the pairs; pairs for the first grid. Out: whether all of them are
// settled; if not, where and by which pair the motion is refused.
//
// Idea (see motion_certifier.hpp): on each grid all pairs pass the run's filters. The pairs left open are tried deepest
// first: at the state that looks most like a collision, by the plane found last, by a descent on the swept bodies. An
// interval is cut further for the pairs that none of these settles, until settled or found within the tolerance.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "math/interruption.hpp"
#include "math/vec.hpp"
#include "motions/motion_report.hpp"

namespace plannercheck {

// Grids have 2, 4 or 8k states: whole lanes on every instruction set.
inline constexpr int kIntervals[] = {1, 3, 7, 15, 23, 31};
inline constexpr std::size_t kGridStates = 32;  // at most

// An interval with pairs left is cut into this many: ε shrinks to a ninth.
inline constexpr int kCut = 3;

// The shortest interval that is cut, as a part of the motion: in shorter ones doubles have few parameters or none.
inline constexpr double kShortestInterval = 0x1p-48;

// A proof that needs more planes than this is given up: pairs that nearly touch on fast curves would fill memory.
inline constexpr std::size_t kMostProofs = std::size_t{1} << 20;

// The smallest first grid on which no point leaves its chords by more than `coarse`, m; `curvature`: a bound of |p''|.
inline int first_intervals(double curvature, double coarse) {
  for (const int n : kIntervals) {
    if (curvature / 8 <= coarse * n * n) return n;
  }
  return kIntervals[std::size(kIntervals) - 1];
}

// The plane (in 2D the line) that separated a pair last.
template <class Direction>
struct Plane {
  std::uint64_t motion = 0;  // in which it was found; 0 if there is none
  Direction direction;       // in the pair's frame
};

// A pair and the intervals on which spheres or circles leave it open, one bit each.
struct NearPair {
  std::int32_t pair;
  unsigned intervals;
};

// Intervals of a pair that the filters leave open, and the state at which the bounds overlap deepest.
struct OpenPair {
  std::int32_t pair;
  unsigned open;
  double depth;
  std::size_t state;
};

// A pair not settled on an interval. `refused`: the parameter of an end where it is within the tolerance, or −1.
struct Failure {
  std::size_t interval;
  std::int32_t pair;
  double refused;
};

// The data of one thread. Space names the types of space or the plane: Direction, Grid, Open (an OpenPair), Counters
// and, for a run, Pair (two bodies), Poses (of both at a state), Workspace.
template <class Space>
struct SubdivisionWorkspace {
  using Direction = typename Space::Direction;

  SubdivisionWorkspace(typename Space::Grid made, std::size_t pairs) : grid(std::move(made)), planes(pairs) {}

  // After this, planes of earlier motions do not count as planes of this one.
  void begin_motion() {
    ++counters.motions;
    ++motion;
    failures.clear();
  }

  typename Space::Grid grid;
  std::vector<NearPair> near;
  std::vector<typename Space::Open> open;
  std::vector<Failure> failures;         // a stack: grids inside grids
  std::vector<Plane<Direction>> planes;  // per pair
  std::uint64_t motion = 0;              // counts the motions begun
  typename Space::Counters counters;
};

// The check of one motion. A class Run derives from it and provides the following; a pair's index is its row in the
// table.
//   pose_grid(from, to, intervals)       poses the states of a grid;
//   near(index)                          the intervals that spheres or circles leave open of a pair, as bits;
//   found_open(index, near)              which of these boxes leave open, and where the bounds are deepest;
//   first_direction(open)                where the motion has no plane of the pair yet; pair's frame, from b to a;
//   apart(index)                         a larger gap at both ends of an interval settles it, m;
//   poses(pair, state)                   the poses of both bodies and of the pair's frame;
//   gap_at(pair, poses, direction)       the gap along the direction, m;
//   swept(pair, poses, count, limit, hint)  a descent at one pose or two: a SweptAnswer;
//   touches(state of a pair, state)      whether no interval at the state can be settled;
//   proves_clear(state of a pair, state) whether the pair is more than the tolerance apart there;
//   fail(state of a pair, interval)      called where plane and descent settle nothing; uses `end_within`, `leave`;
//   proof(state of a pair, from, to, least gap of both ends).
template <class Run, class Space>
class AdaptiveSubdivision {
 public:
  using Direction = typename Space::Direction;
  using Proofs = std::vector<IntervalProof<Direction>>;

  // Looks for the first place where the motion is refused. With `proofs`, records the proofs of all pairs.
  void in_order(Proofs* proofs) { ordered_ = true, proofs_ = proofs; }

 protected:
  using Pair = typename Space::Pair;
  using Poses = typename Space::Poses;
  using Open = typename Space::Open;
  using Workspace = typename Space::Workspace;

  AdaptiveSubdivision(const std::vector<Pair>& pairs, Workspace& workspace) : pairs_(pairs), w_(workspace) {}

  const std::vector<Pair>& pairs_;
  Workspace& w_;
  bool ordered_ = false;
  Proofs* proofs_ = nullptr;
  MotionReport report_;

  // What is known of a pair on the grid, apart from its plane.
  struct PairState {
    const Pair& pair;
    std::int32_t index;
    double apart;
    Plane<Direction>& plane;
    unsigned measured = 0, checked = 0;  // states whose gap along the plane is known; states proved clear
    std::array<double, kGridStates> gaps;
  };

  // A run may replace the following: the motion's parameter for a grid's, the choice of what the next grid poses, what
  // settles an interval, and collisions that are found before any pair is settled.
  double parameter(double t) const { return t; }
  void choose(const std::vector<std::int32_t>&) {}

  // Whether one direction keeps the swept bodies apart on an interval: the plane found last, or a descent's.
  bool hulls_settle(PairState& s, std::size_t i) { return plane_settles(s, i) || sweep_settles(s, i); }

  // Whether bodies keep apart on an interval although their swept hulls do not.
  bool parts_settle(PairState&, std::size_t) { return false; }

  // Whether bounds may prove on the current grid that a near pair collides at a state; and whether they do so, then the
  // report says where.
  bool begin_collisions() { return false; }
  bool surely_collides(const NearPair&) { return false; }

  void place(double from, double to, int intervals) {
    poll_interruption();
    ++w_.counters.grids;
    w_.counters.states += intervals + 1;
    self().pose_grid(from, to, intervals);
  }

  // ----- grids inside grids

  // Whether all pairs are settled on the current grid; if not, the report says where the motion is refused.
  bool judge_grid(const std::vector<std::int32_t>& candidates) {
    if (proofs_ != nullptr && proofs_->size() > kMostProofs) {
      return refuse_at(w_.grid.parameter(0), candidates.front());
    }
    const std::size_t base = w_.failures.size();
    const unsigned all = (1U << w_.grid.intervals()) - 1;
    w_.near.clear();
    w_.counters.pairs += static_cast<long>(candidates.size());
    const bool seeks_collisions = !ordered_ && self().begin_collisions();
    for (const std::int32_t index : candidates) {
      const unsigned near = proofs_ != nullptr ? all : self().near(index);
      if (near == 0) continue;
      w_.counters.intervals += __builtin_popcount(near);
      w_.near.push_back({index, near});
      if (seeks_collisions && self().surely_collides(w_.near.back())) return false;
    }
    w_.open.clear();
    for (const NearPair& pair : w_.near) {
      const Open found = self().found_open(pair.pair, pair.intervals);
      if (found.open != 0) w_.open.push_back(found);
    }
    // The likeliest to collide first: the pair whose bounds overlap deepest.
    std::sort(w_.open.begin(), w_.open.end(), [](const auto& a, const auto& b) { return a.depth < b.depth; });
    for (const Open& found : w_.open) {
      if (!ordered_ && touches_where_deepest(found)) return false;
    }
    for (const Open& found : w_.open) {
      if (!settle(found)) return false;
    }
    return w_.failures.size() == base || cut_failures(base);
  }

  bool cut_failures(std::size_t base) {
    std::vector<Failure> failures(w_.failures.begin() + static_cast<std::ptrdiff_t>(base), w_.failures.end());
    w_.failures.resize(base);
    std::stable_sort(failures.begin(), failures.end(),
                     [](const Failure& a, const Failure& b) { return a.interval < b.interval; });
    std::array<double, kGridStates> t;
    for (std::size_t i = 0; i <= w_.grid.intervals(); ++i) t[i] = w_.grid.parameter(i);
    for (std::size_t k = 0; k < failures.size();) {
      const std::size_t interval = failures[k].interval;
      report_.free_until = self().parameter(t[interval]);
      Failure first{interval, -1, 2};  // the earliest one that is refused
      std::vector<std::int32_t> pairs;
      for (; k < failures.size() && failures[k].interval == interval; ++k) {
        if (failures[k].refused >= 0 && failures[k].refused < first.refused) first = failures[k];
        pairs.push_back(failures[k].pair);
      }
      if (first.refused <= t[interval]) return refuse_at(first.refused, first.pair);
      // On so short an interval a pair stays open only if the distances at its ends are on both sides of the tolerance.
      if (!(t[interval + 1] - t[interval] > kShortestInterval)) {
        return first.pair >= 0 ? refuse_at(first.refused, first.pair) : refuse_at(t[interval], pairs.front());
      }
      self().choose(pairs);
      place(t[interval], t[interval + 1], kCut);
      if (!judge_grid(pairs)) return false;
      if (first.pair >= 0) {
        report_.free_until = self().parameter(t[interval + 1]);
        return refuse_at(first.refused, first.pair);
      }
    }
    return true;
  }

  bool refuse_at(double t, std::int32_t pair) {
    report_.refused = self().parameter(t), report_.pair = pair;
    return false;
  }

  // ----- one pair on one grid

  PairState state_of(const Open& found) {
    PairState s{pairs_[at(found.pair)], found.pair, self().apart(found.pair), w_.planes[at(found.pair)], 0, 0, {}};
    if (s.plane.motion != w_.motion) s.plane = {w_.motion, self().first_direction(found)};
    return s;
  }

  // Whether a pair shares a point at the state that looks most like a collision; then the motion is refused there.
  bool touches_where_deepest(const Open& found) {
    if (!(found.depth < 0)) return false;
    PairState s = state_of(found);
    const int state = touching_state(s, found.state);
    return state >= 0 && !refuse_at(w_.grid.parameter(static_cast<std::size_t>(state)), found.pair);
  }

  // The state at which the pair shares a point, of the one where the bounds overlap deepest and the one inside of it if
  // that is an end; −1 if there is none.
  int touching_state(PairState& s, std::size_t deepest) {
    const std::size_t inner = inner_state(deepest);
    if (self().touches(s, inner)) return static_cast<int>(inner);
    return inner != deepest && self().touches(s, deepest) ? static_cast<int>(deepest) : -1;
  }

  // Planners ask for motions between states that are free, so the state next to an end is likelier to collide.
  std::size_t inner_state(std::size_t state) const {
    const std::size_t last = w_.grid.intervals() - 1;
    return last == 0 ? state : std::clamp<std::size_t>(state, 1, last);
  }

  // Settles the intervals of a pair or leaves them as failures; false if the pair is within the tolerance.
  bool settle(const Open& found) {
    PairState s = state_of(found);
    // Called in order as well: it finds a plane, which may decide where rounding does.
    if (ordered_ && found.depth < 0) touching_state(s, found.state);
    for (unsigned open = found.open; open != 0; open &= open - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(open));
      if (self().hulls_settle(s, i) || self().parts_settle(s, i)) {
        prove(s, i);
      } else if (!self().fail(s, i)) {
        return false;
      }
    }
    return true;
  }

  bool plane_settles(PairState& s, std::size_t i) { return gap(s, i) > s.apart && gap(s, i + 1) > s.apart; }

  double gap(PairState& s, std::size_t state) {
    if ((s.measured >> state & 1U) == 0) {
      s.measured |= 1U << state;
      ++w_.counters.planes;
      s.gaps[state] = self().gap_at(s.pair, self().poses(s.pair, state), s.plane.direction);
    }
    return s.gaps[state];
  }

  bool sweep_settles(PairState& s, std::size_t i) {
    const std::array<Poses, 2> ends{self().poses(s.pair, i), self().poses(s.pair, i + 1)};
    return sweep(s, ends.data(), 2, s.apart).apart;
  }

  SweptAnswer<Direction> sweep_at(PairState& s, std::size_t state, double limit) {
    const Poses here = self().poses(s.pair, state);
    return sweep(s, &here, 1, limit);
  }

  SweptAnswer<Direction> sweep(PairState& s, const Poses* poses, int count, double limit) {
    ++w_.counters.swept;
    const SweptAnswer<Direction> answer = self().swept(s.pair, poses, count, limit, s.plane.direction);
    learn(s, answer.direction);
    return answer;
  }

  void learn(PairState& s, Direction direction) {
    s.plane = {w_.motion, direction};
    s.measured = 0;
  }

  void prove(PairState& s, std::size_t i) {
    if (proofs_ == nullptr) return;
    const double least = smaller(gap(s, i), gap(s, i + 1));
    proofs_->push_back(self().proof(s, w_.grid.parameter(i), w_.grid.parameter(i + 1), least));
  }

  // ----- an interval that neither its plane nor a descent settles

  // The parameter of an end at which the pair is within the tolerance; −1 if there is none.
  double end_within(PairState& s, std::size_t i) {
    if (!clear(s, i)) return w_.grid.parameter(i);
    return clear(s, i + 1) ? -1 : w_.grid.parameter(i + 1);
  }

  // Whether the pair is proved to be more than the tolerance apart at a state; if not, it is within the tolerance.
  bool clear(PairState& s, std::size_t state) {
    if ((s.checked >> state & 1U) != 0) return true;
    if (!self().proves_clear(s, state)) return false;
    s.checked |= 1U << state;
    return true;
  }

  // False if the pair is within the tolerance at an end. In order, the interval is cut further even then.
  bool leave(PairState& s, std::size_t i, double refused) {
    if (!ordered_ && refused >= 0) return refuse_at(refused, s.index);
    w_.failures.push_back({i, s.index, refused});
    return true;
  }

 private:
  Run& self() { return static_cast<Run&>(*this); }
};

}  // namespace plannercheck
