// One planar motion's check: grids of states, finer where pairs are not settled; the steps are those of
// motion_check.cpp.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "math/vec.hpp"
#include "planar/motion_certifier_2d.hpp"
#include "planar/motion_filters_2d.hpp"
#include "planar/motion_grid_2d.hpp"

namespace plannercheck {
namespace {

// Grids have 2, 4 or 8k states: whole lanes on every instruction set.
constexpr int kPlanarIntervals[] = {1, 3, 7, 15, 23, 31};

// The first grid is so fine that no body leaves its chords by more than this, m (measured).
constexpr double kPlanarCoarse = 0.05;

// Into how many intervals one is cut that has pairs left: ε shrinks to a ninth.
constexpr int kPlanarCut = 3;

// Rounding and a piece's slip may take at most this part of the tolerance: twice as much has to be less than it for
// intervals to become short enough. Where rounding takes more, the numbers are too large; where a slip does, the piece
// is judged with a greater tolerance.
constexpr double kPlanarRoundingPart = 1.0 / 4;

}  // namespace

struct PlanarLine {
  std::uint64_t motion = 0;   // by which it was found; of another motion it counts for nothing
  PlanarDirection direction;  // in the pair's frame
};

// A pair that is not settled on an interval; `refused`: the parameter of an end at which it is within the tolerance, -1
// if there is none.
struct PlanarFailure {
  std::size_t interval;
  std::int32_t pair;
  double refused;
};

// Intervals of a pair that circles leave open, and the state at which the circle is deepest in the other body's bound.
struct OpenPlanarPair {
  std::int32_t pair;
  unsigned open;
  double depth;
  std::size_t state;
};

class PlanarCertifier::Workspace {
 public:
  Workspace(const std::vector<PlanarLink>& links, std::size_t width, const std::vector<PlanarBody>& bodies,
            const std::vector<std::int32_t>& movers, std::size_t pairs)
      : grid(links, width, bodies, movers), rates(width), bounds(pairs), lines(pairs), all(pairs) {
    std::iota(all.begin(), all.end(), 0);
  }

  // The lines of earlier motions end with that: they could settle an interval that by itself rounds to the other side.
  void begin_motion() {
    ++motion;
    failures.clear();
  }

  PlanarGrid grid;
  std::vector<double> rates;
  std::vector<PlanarBound> bounds;  // per pair, of both bodies together
  std::vector<OpenPlanarPair> open;
  std::vector<PlanarFailure> failures;  // a stack: grids inside grids
  std::vector<PlanarLine> lines;        // per pair
  std::vector<std::int32_t> all;
  std::uint64_t motion = 0;  // how many were begun
  PlanarMotionCounters counters;
};

// One motion's check.
class PlanarRun {
 public:
  PlanarRun(const PlanarCertifier& certifier, const PlanarMotion& motion, double tolerance,
            PlanarCertifier::Workspace& workspace)
      : certifier_(certifier), motion_(motion), given_tolerance_(tolerance), w_(workspace) {}

  void in_order(std::vector<PlanarProof>* proofs) { ordered_ = true, proofs_ = proofs; }

  MotionReport run() {
    ++w_.counters.motions;
    w_.begin_motion();
    const double rounding = certifier_.rounding(motion_);
    if (!(rounding <= kPlanarRoundingPart * given_tolerance_)) return {MotionAnswer::kImprecise, 0, 0, -1};
    for (std::size_t k = 0; k < motion_.count; ++k) {
      slack_ = rounding + motion_.pieces[k].slip;
      tolerance_ = larger(given_tolerance_, slack_ / kPlanarRoundingPart);
      begin(motion_.pieces[k]);
      report_.free_until = piece_->from;
      if (!judge_grid(w_.all)) {
        report_.answer = MotionAnswer::kRefused;
        return report_;
      }
    }
    report_.free_until = 1;
    return report_;
  }

 private:
  const PlanarCertifier& certifier_;
  const PlanarMotion& motion_;
  double given_tolerance_, tolerance_ = 0;
  PlanarCertifier::Workspace& w_;
  bool ordered_ = false;
  std::vector<PlanarProof>* proofs_ = nullptr;
  const PlanarPiece* piece_ = nullptr;
  double slack_ = 0, way_ = 0;  // the root's on the piece, m
  MotionReport report_;

  // ----- a piece's first grid

  void begin(const PlanarPiece& piece) {
    piece_ = &piece;
    way_ = norm_above({piece.way_x, piece.way_y, 0}) * (1 + 0x1p-40);
    for (std::size_t c = 0; c < w_.rates.size(); ++c)
      w_.rates[c] = (piece.to - piece.from) * (motion_.q1[c] - motion_.q0[c]);
    if (certifier_.links_[0].joint == PlanarJoint::kFree) w_.rates[2] = piece.turn;
    double largest = 0;
    for (std::size_t p = 0; p < w_.bounds.size(); ++p) {
      const PlanarMotionPair& pair = certifier_.pairs_[p];
      const PlanarBound a = planar_bound(pair.chain_a, piece, w_.rates);
      const PlanarBound b = planar_bound(pair.chain_b, piece, w_.rates);
      const double slide = pair.frame < 0 ? way_ : 0;
      w_.bounds[p] = {a.curvature + b.curvature, a.speed + b.speed + slide};
      largest = larger(largest, w_.bounds[p].curvature);
    }
    place(0, 1, first_intervals(largest));
  }

  static int first_intervals(double curvature) {
    for (const int n : kPlanarIntervals) {
      if (curvature / 8 <= kPlanarCoarse * n * n) return n;
    }
    return kPlanarIntervals[std::size(kPlanarIntervals) - 1];
  }

  void place(double from, double to, int intervals) {
    ++w_.counters.grids;
    w_.counters.states += intervals + 1;
    w_.grid.place(motion_.q0, motion_.q1, *piece_, from, to, intervals);
  }

  // A state's parameter of the motion.
  double parameter(double s) const { return s >= 1 ? piece_->to : piece_->from + s * (piece_->to - piece_->from); }

  // ----- what is known of a pair on the grid

  const PlanarBody& body(std::int32_t index) const { return certifier_.bodies_[at(index)]; }
  const PlanarHull& hull(std::int32_t index) const { return certifier_.hulls_[at(index)]; }
  double bulge(std::int32_t pair) const { return w_.bounds[at(pair)].curvature * w_.grid.step() * w_.grid.step() / 8; }
  // More than this along a direction at both ends of an interval settles it.
  double apart(std::int32_t pair) const { return bulge(pair) + slack_; }

  PlanarPlaces places(const PlanarMotionPair& pair, std::size_t state) const {
    return {w_.grid.place_of(body(pair.a).link, state), w_.grid.place_of(body(pair.b).link, state),
            w_.grid.place_of(pair.frame, state)};
  }

  struct PairState {
    const PlanarMotionPair& pair;
    std::int32_t index;
    double apart;
    PlanarLine& line;
    unsigned measured = 0, checked = 0;  // states whose gap along the line is known; states that are proved clear
    std::array<double, kPlanarStates> gaps;
  };

  // ----- circles and boxes

  OpenPlanarPair found_open(std::int32_t index) {
    const PlanarMotionPair& pair = certifier_.pairs_[at(index)];
    OpenPlanarPair found{index, (1U << w_.grid.intervals()) - 1, 0, 0};
    const bool still = body(pair.b).link < 0;
    if (proofs_ == nullptr) found.open = near(pair, index);
    if (found.open == 0) return found;
    w_.counters.intervals += __builtin_popcount(found.open);
    found.depth = HUGE_VAL;
    for (unsigned open = found.open | found.open << 1; open != 0; open &= open - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(open));
      const PlanarVector v = between(pair, i);
      const double depth = std::sqrt(v.x * v.x + v.y * v.y) - body(pair.a).radius - (still ? 0 : body(pair.b).radius);
      if (depth < found.depth) found.depth = depth, found.state = i;
    }
    PlanarLine& line = w_.lines[at(index)];
    if (line.motion != w_.motion) {
      const PlanarVector v = w_.grid.place_of(pair.frame, found.state).turned_back(between(pair, found.state));
      line = {w_.motion, PlanarDirection::along(v)};
    }
    return found;
  }

  unsigned near(const PlanarMotionPair& pair, std::int32_t index) const {
    const PlanarBody &a = body(pair.a), &b = body(pair.b);
    if (b.link < 0) return chords_meet_box(w_.grid, pair.a, b.box, a.radius + apart(index));
    const double moved = w_.bounds[at(index)].speed * w_.grid.step() / 2;
    return centres_come_near(w_.grid, pair.a, pair.b, a.radius + b.radius + slack_ + moved);
  }

  // From the nearest point of b's box, or b's centre, to a's centre.
  PlanarVector between(const PlanarMotionPair& pair, std::size_t state) const {
    const double* a = w_.grid.centre(pair.a) + state;
    if (body(pair.b).link >= 0) {
      const double* b = w_.grid.centre(pair.b) + state;
      return {a[0] - b[0], a[kPlanarRow] - b[kPlanarRow]};
    }
    const std::array<double, 4>& box = body(pair.b).box;
    const double x = a[0], y = a[kPlanarRow];
    return {x - std::clamp(x, box[0], box[2]), y - std::clamp(y, box[1], box[3])};
  }

  // ----- one pair on one grid

  // Settles the intervals of a pair or notes them down as failures; false if the pair is within the tolerance.
  bool settle(const OpenPlanarPair& found) {
    PairState s{certifier_.pairs_[at(found.pair)], found.pair, apart(found.pair), w_.lines[at(found.pair)], 0, 0, {}};
    // In order, too: what it learns of the line may decide where rounding does.
    if (found.depth < 0 && !is_apart(s, found.state, slack_) && !ordered_) {
      return refuse_at(w_.grid.parameter(found.state), found.pair);
    }
    for (unsigned open = found.open; open != 0; open &= open - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(open));
      if (line_settles(s, i) || sweep_settles(s, i)) {
        if (proofs_ != nullptr) prove(s, i);
      } else if (!fail(s, i)) {
        return false;
      }
    }
    return true;
  }

  void prove(PairState& s, std::size_t i) {
    proofs_->push_back({s.index, parameter(w_.grid.parameter(i)), parameter(w_.grid.parameter(i + 1)), s.line.direction,
                        smaller(gap(s, i), gap(s, i + 1)) - slack_, bulge(s.index)});
  }

  bool line_settles(PairState& s, std::size_t i) { return gap(s, i) > s.apart && gap(s, i + 1) > s.apart; }

  double gap(PairState& s, std::size_t state) {
    if ((s.measured >> state & 1U) == 0) {
      s.measured |= 1U << state;
      ++w_.counters.lines;
      s.gaps[state] = planar_gap(hull(s.pair.a), hull(s.pair.b), places(s.pair, state), s.line.direction);
    }
    return s.gaps[state];
  }

  bool sweep_settles(PairState& s, std::size_t i) {
    const std::array<PlanarPlaces, 2> ends{places(s.pair, i), places(s.pair, i + 1)};
    return sweep(s, ends.data(), 2, s.apart);
  }

  bool sweep(PairState& s, const PlanarPlaces* at_ends, int count, double limit) {
    ++w_.counters.swept;
    const PlanarApart answer = planar_apart(hull(s.pair.a), hull(s.pair.b), at_ends, count, limit, s.line.direction);
    s.line = {w_.motion, answer.direction};
    s.measured = 0;
    return answer.apart;
  }

  // An interval that nothing settles: false if the pair is within the tolerance at an end, or the interval so short
  // that it is within the tolerance all the way. In order, the interval is looked at further all the same.
  bool fail(PairState& s, std::size_t i) {
    const double way = w_.bounds[at(s.index)].speed * w_.grid.step();
    const bool short_enough = way + bulge(s.index) + 2 * slack_ <= tolerance_;
    double refused = -1;
    if (short_enough || !clear(s, i)) {
      refused = w_.grid.parameter(i);
    } else if (!clear(s, i + 1)) {
      refused = w_.grid.parameter(i + 1);
    }
    if (!ordered_ && refused >= 0) return refuse_at(refused, s.index);
    w_.failures.push_back({i, s.index, refused});
    return true;
  }

  bool refuse_at(double s, std::int32_t pair) {
    report_.refused = parameter(s), report_.pair = pair;
    return false;
  }

  // Whether the pair is proved to be more than the tolerance apart at a state; if not, it is within it.
  bool clear(PairState& s, std::size_t state) {
    if ((s.checked >> state & 1U) != 0) return true;
    if (!is_apart(s, state, tolerance_ - 2 * slack_)) return false;
    s.checked |= 1U << state;
    return true;
  }

  bool is_apart(PairState& s, std::size_t state, double limit) {
    const PlanarPlaces here = places(s.pair, state);
    return sweep(s, &here, 1, limit);
  }

  // ----- grids inside grids

  bool judge_grid(const std::vector<std::int32_t>& candidates) {
    const std::size_t base = w_.failures.size();
    w_.open.clear();
    for (const std::int32_t index : candidates) {
      const OpenPlanarPair found = found_open(index);
      if (found.open != 0) w_.open.push_back(found);
    }
    // The likeliest to collide first.
    std::sort(w_.open.begin(), w_.open.end(),
              [](const OpenPlanarPair& a, const OpenPlanarPair& b) { return a.depth < b.depth; });
    for (const OpenPlanarPair& found : w_.open) {
      if (!settle(found)) return false;
    }
    return w_.failures.size() == base || cut_failures(base);
  }

  bool cut_failures(std::size_t base) {
    std::vector<PlanarFailure> failures(w_.failures.begin() + static_cast<std::ptrdiff_t>(base), w_.failures.end());
    w_.failures.resize(base);
    std::stable_sort(failures.begin(), failures.end(),
                     [](const PlanarFailure& a, const PlanarFailure& b) { return a.interval < b.interval; });
    std::array<double, kPlanarStates> s;
    for (std::size_t i = 0; i <= w_.grid.intervals(); ++i) s[i] = w_.grid.parameter(i);
    for (std::size_t k = 0; k < failures.size();) {
      const std::size_t interval = failures[k].interval;
      report_.free_until = parameter(s[interval]);
      PlanarFailure first{interval, -1, 2};  // the one that is refused first
      std::vector<std::int32_t> pairs;
      for (; k < failures.size() && failures[k].interval == interval; ++k) {
        if (failures[k].refused >= 0 && failures[k].refused < first.refused) first = failures[k];
        pairs.push_back(failures[k].pair);
      }
      if (first.refused <= s[interval]) return refuse_at(first.refused, first.pair);
      place(s[interval], s[interval + 1], kPlanarCut);
      if (!judge_grid(pairs)) return false;
      if (first.pair >= 0) {
        report_.free_until = parameter(s[interval + 1]);
        return refuse_at(first.refused, first.pair);
      }
    }
    return true;
  }
};

void PlanarCertifier::WorkspaceDeleter::operator()(Workspace* workspace) const { delete workspace; }

PlanarCertifier::WorkspacePointer PlanarCertifier::new_workspace() const {
  return WorkspacePointer(new Workspace(links_, width_, bodies_, movers_, pairs_.size()));
}

PlanarMotionCounters PlanarCertifier::take_counters(Workspace& workspace) {
  return std::exchange(workspace.counters, {});
}

MotionReport PlanarCertifier::check(const PlanarMotion& motion, double tolerance, Workspace& workspace) const {
  return PlanarRun(*this, motion, tolerance, workspace).run();
}

MotionReport PlanarCertifier::explain(const PlanarMotion& motion, double tolerance, std::vector<PlanarProof>* proofs,
                                      Workspace& workspace) const {
  PlanarRun run(*this, motion, tolerance, workspace);
  run.in_order(proofs);
  return run.run();
}

// The first piece that reaches each parameter is taken.
void PlanarCertifier::states(const PlanarMotion& motion, const double* t, std::size_t n, double* q,
                             Workspace& workspace) const {
  for (std::size_t i = 0; i < n; ++i) {
    if (t[i] <= 0 || t[i] >= 1) {
      std::copy_n(t[i] <= 0 ? motion.q0 : motion.q1, width_, q + i * width_);
      continue;
    }
    std::size_t k = 0;
    while (k + 1 < motion.count && t[i] > motion.pieces[k].to) ++k;
    const PlanarPiece& piece = motion.pieces[k];
    const double length = piece.to - piece.from;
    workspace.grid.configure(motion.q0, motion.q1, piece, broadcast(length > 0 ? (t[i] - piece.from) / length : 0));
    for (std::size_t c = 0; c < width_; ++c) q[i * width_ + c] = workspace.grid.columns()[c][0];
  }
}

}  // namespace plannercheck
