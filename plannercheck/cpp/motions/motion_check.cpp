// One motion's check: grids of states, finer where pairs are not settled (see motion_certifier.hpp).
//
// In: a certifier, a workspace, a motion. Out: a report. On each grid all pairs pass the filters; what they leave open
// is taken deepest first: the state that looks most like a collision, the plane found last, a descent on the swept
// bodies. An interval is cut further for the pairs that nothing settles, until they are settled or found within the
// tolerance.
#include <algorithm>
#include <numeric>
#include <utility>

#include "motions/motion_certifier.hpp"
#include "motions/motion_filters.hpp"
#include "narrow_phase/distance.hpp"

namespace plannercheck {

struct Plane {
  std::uint64_t motion = 0;  // by which it was found, 0 if there is none
  Vec3 direction;            // in the pair's frame
};

// A pair that is not settled on an interval; `refused`: the parameter of an end at which it is within the tolerance, −1
// if there is none.
struct Failure {
  std::size_t interval;
  std::int32_t pair;
  double refused;
};

namespace {

// Grids have 2, 4 or 8k states: whole lanes on every instruction set.
constexpr int kIntervals[] = {1, 3, 7, 15, 23, 31};

// The first grid is so fine that no body leaves its chords by more than this, m: coarser ones leave more pairs to the
// costlier tests, finer ones pose more states (measured).
constexpr double kCoarse = 0.02;

// Into how many intervals one is cut that has pairs left: ε shrinks to a ninth.
constexpr int kCut = 3;

// Boxes that are deeper in each other along a hint than this part of the smaller body's radius: the hulls would have to
// leave that much of them free, which few do (a sixth of the Panda's pairs).
constexpr double kDeepestHint = 1;

// All rounding here (poses of bodies, directions, products, boxes) is some hundred u = 2^-53 of the sizes that enter.
constexpr double kRunRounding = 0x1p-42, kUnit = 0x1p-53;

// And for each joint on a chain, as which the frame's computed turn errs, and for each part: the numbers of a
// quaternion between the ends err by up to 62u.
constexpr double kTurnRounding = 64 * kUnit, kPartRounding = 144 * kUnit;

// Rounding may take at most this part of the tolerance, else the numbers are too large.
constexpr double kRoundingPart = 1.0 / 16;

using Row = std::array<double, kGridRow>;

}  // namespace

class MotionCertifier::Workspace {
 public:
  explicit Workspace(const MotionModel& model)
      : path(at(model.width), model.parts),
        grid(model.bodies, at(model.width), at(model.links)),
        planes(model.pairs.size()) {}

  // With that the planes of earlier motions are mere hints (see `hint_settles`).
  void begin_motion() {
    ++motion;
    failures.clear();
  }

  ConfigurationPath path;
  MotionGrid grid;
  std::vector<Rate> rates;
  std::vector<MotionBound> bounds;  // per chain
  std::vector<std::int32_t> candidates, bodies, frames;
  std::vector<OpenPair> open;
  std::vector<Failure> failures;  // a stack: grids inside grids
  std::vector<Plane> planes;      // per pair
  std::uint64_t motion = 0;       // how many were begun
  MotionCounters counters;
};

// One motion's check.
class MotionRun {
 public:
  MotionRun(const MotionCertifier& certifier, const Kinematics& kinematics, double tolerance, double kinematic_error,
            MotionCertifier::Workspace& workspace)
      : certifier_(certifier),
        model_(certifier.model_),
        kinematics_(kinematics),
        tolerance_(tolerance),
        kinematic_error_(kinematic_error),
        w_(workspace),
        filters_(model_, certifier.defects_, workspace.grid, workspace.bounds) {}

  void in_order(std::vector<MotionProof>* proofs) { ordered_ = true, proofs_ = proofs; }

  MotionReport run(const double* q0, const double* q1) {
    begin(q0, q1);
    if (!(filters_.slack() <= kRoundingPart * tolerance_)) return {MotionAnswer::kImprecise, 0, 0, -1};
    if (proofs_ != nullptr) {
      w_.candidates.resize(model_.pairs.size());
      std::iota(w_.candidates.begin(), w_.candidates.end(), 0);
    } else {
      find_candidates();
    }
    report_.answer = judge_grid(w_.candidates) ? MotionAnswer::kFree : MotionAnswer::kRefused;
    if (report_.answer == MotionAnswer::kFree) report_.free_until = 1;
    return report_;
  }

 private:
  const MotionCertifier& certifier_;
  const MotionModel& model_;
  const Kinematics& kinematics_;
  double tolerance_, kinematic_error_;
  bool ordered_ = false;
  std::vector<MotionProof>* proofs_ = nullptr;
  MotionCertifier::Workspace& w_;
  MotionFilters filters_;
  MotionReport report_;

  // ----- the first grid

  void begin(const double* q0, const double* q1) {
    ++w_.counters.motions;
    w_.begin_motion();
    w_.path.set(q0, q1);
    rates_of(model_.chains, w_.path, w_.rates);
    w_.bounds.resize(model_.chains.first_entry.size() - 1);
    double largest = 0, arm = 0;
    for (std::size_t chain = 0; chain < w_.bounds.size(); ++chain) {
      w_.bounds[chain] = bound_of(model_.chains, chain, w_.rates);
      largest = larger(largest, w_.bounds[chain].curvature);
      arm = larger(arm, w_.bounds[chain].arm);
    }
    w_.grid.choose(certifier_.movers_, certifier_.frames_);
    place(0, 1, first_intervals(largest));
    set_rounding(q0, q1, largest, arm);
  }

  static int first_intervals(double curvature) {
    for (const int n : kIntervals) {
      if (curvature / 8 <= kCoarse * n * n) return n;
    }
    return kIntervals[std::size(kIntervals) - 1];
  }

  void place(double from, double to, int intervals) {
    ++w_.counters.grids;
    w_.counters.states += intervals + 1;
    w_.grid.place(kinematics_, w_.path, from, to, intervals);
  }

  // How far a gap of two bodies may be off, by the sizes of what is computed with:
  // - kinematics: each body's computed pose is off by an error at the states of the grid, from which follows what is
  //   proved of exact poses; and the computed poses of any state between are off these by as much again: four errors;
  // - rounding here, of numbers up to how far any body can be from the world's origin, and placements off rigid, as
  //   which directions and chords in links' frames are;
  // - states go along unit quaternions, cosines and sines, while the ends are posed as they are given. A quaternion of
  //   length 1 + ε and that of length 1 differ as matrices by 4ε at most, a circle by ε; each such part on a body's
  //   chain moves it by as much of its arm, and both bodies have up to `depth` of them;
  // - the configurations between the ends, whose numbers err by at most 8u of the ends', which each joint turns into as
  //   much of its arm.
  void set_rounding(const double* q0, const double* q1, double largest, double arm) {
    double size = 1 + certifier_.still_size_ + certifier_.mounted_size_ + model_.extent + largest / 8 + arm;
    for (std::size_t c = 0; c < model_.travel.size(); ++c)
      size += model_.travel[c] * larger(std::fabs(q0[c]), std::fabs(q1[c]));
    const double part = kRunRounding + kTurnRounding * model_.joints + kPartRounding * model_.depth +
                        4 * model_.defect + 8 * model_.depth * w_.path.off_unit() +
                        16 * kUnit * model_.leverage * (1 + w_.path.largest());
    filters_.set_rounding(4 * kinematic_error_ + part * size, size);
  }

  // Pairs of which the boxes around both bodies' whole paths meet, and pairs of two bodies that move.
  void find_candidates() {
    w_.candidates = certifier_.among_self_;
    for (std::size_t m = 0; m < certifier_.movers_.size(); ++m) {
      if (certifier_.chain_in_world_[m] < 0) continue;
      const auto box = filters_.box_around_path(certifier_.movers_[m], certifier_.chain_in_world_[m]);
      certifier_.find_near(m, box[0], box[1], w_.candidates);
    }
  }

  // ----- one pair on one grid

  // What is known of a pair on the grid, besides its plane.
  struct PairState {
    const CertifiedPair& pair;
    std::int32_t index;
    double apart;
    Plane& plane;
    unsigned measured = 0, checked = 0;  // states whose gap along the plane is known; states that are proved clear
    Row gaps;
  };

  // Settles the intervals of a pair or notes them down as failures; false if the pair is within the tolerance.
  bool settle(const OpenPair& found) {
    const CertifiedPair& pair = model_.pairs[at(found.pair)];
    PairState s{pair, found.pair, filters_.apart(pair), w_.planes[at(found.pair)], 0, 0, {}};
    if (s.plane.motion != w_.motion) s.plane = {w_.motion, found.direction};
    // In order, too: what it learns of the plane may decide where rounding does.
    if (found.depth < 0 && touches(s, found.state) && !ordered_) {
      return refuse_at(w_.grid.parameter(found.state), found.pair);
    }
    for (unsigned open = found.open; open != 0; open &= open - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(open));
      if (plane_settles(s, i) || sweep_settles(s, i)) {
        if (proofs_ != nullptr) prove(s, i);
      } else if (!fail(s, i)) {
        return false;
      }
    }
    return true;
  }

  // What spheres and boxes leave open of a pair: along the plane found last, and along a direction that they suggest.
  OpenPair found_open(std::int32_t index) {
    const CertifiedPair& pair = model_.pairs[at(index)];
    const Plane& plane = w_.planes[at(index)];
    OpenPair found{index, proofs_ != nullptr ? filters_.all_intervals() : filters_.near(pair), 0, 0, {}};
    w_.counters.intervals += __builtin_popcount(found.open);
    if (found.open != 0 && proofs_ == nullptr && plane.motion != 0) {
      if (plane.motion == w_.motion) {
        filters_.boxes_settle(found, plane.direction);
      } else if (hint_settles(pair, found, plane.direction)) {
        found.open = 0;
      }
    }
    if (found.open == 0) return found;
    found.direction = filters_.between(pair, static_cast<std::size_t>(__builtin_ctz(found.open)));
    if (proofs_ == nullptr) filters_.boxes_settle(found, found.direction);
    return found;
  }

  // Whether a plane of an earlier motion keeps the pair apart by more than twice the tolerance wherever it is open.
  // Then it is within the tolerance at no state of this motion, so that the way without hints, which refuses a motion
  // only by such a state, settles the pair as well. A hint that leaves anything open counts for nothing.
  bool hint_settles(const CertifiedPair& pair, const OpenPair& found, Vec3 direction) {
    if (ordered_ || !certifier_.hints_) return false;
    OpenPair left = found;
    filters_.boxes_settle(left, direction, 2 * tolerance_);
    if (left.open == 0) return true;
    const double radius = smaller(filters_.body(pair.a).radius, filters_.body(pair.b).radius);
    if (left.depth < -kDeepestHint * radius) return false;
    const double apart = filters_.apart(pair) + 2 * tolerance_;
    for (unsigned states = left.open | left.open << 1; states != 0; states &= states - 1) {
      const PosedPair posed = filters_.posed(pair, static_cast<std::size_t>(__builtin_ctz(states)));
      ++w_.counters.planes;
      if (!(gap_along(filters_.body(pair.a), filters_.body(pair.b), posed, direction, w_.counters.pair) > apart))
        return false;
    }
    return true;
  }

  void prove(PairState& s, std::size_t i) {
    const double least = smaller(gap(s, i), gap(s, i + 1)) - filters_.swells(s.pair) - filters_.slack();
    proofs_->push_back(
        {s.index, w_.grid.parameter(i), w_.grid.parameter(i + 1), s.plane.direction, least, filters_.bulge(s.pair)});
  }

  bool plane_settles(PairState& s, std::size_t i) { return gap(s, i) > s.apart && gap(s, i + 1) > s.apart; }

  double gap(PairState& s, std::size_t state) {
    if ((s.measured >> state & 1U) == 0) {
      s.measured |= 1U << state;
      ++w_.counters.planes;
      s.gaps[state] = gap_along(filters_.body(s.pair.a), filters_.body(s.pair.b), filters_.posed(s.pair, state),
                                s.plane.direction, w_.counters.pair);
    }
    return s.gaps[state];
  }

  bool sweep_settles(PairState& s, std::size_t i) {
    const std::array<PosedPair, 2> ends{filters_.posed(s.pair, i), filters_.posed(s.pair, i + 1)};
    const SweptAnswer answer = sweep(s, ends.data(), 2, s.apart);
    return answer.reach == Reach::kApart;
  }

  SweptAnswer sweep(PairState& s, const PosedPair* poses, int count, double apart) {
    ++w_.counters.swept;
    const SweptAnswer answer = swept_distance(filters_.body(s.pair.a), filters_.body(s.pair.b), poses, count, apart,
                                              s.plane.direction, w_.counters.pair);
    s.plane = {w_.motion, answer.direction};
    s.measured = 0;
    return answer;
  }

  // An interval that neither its plane nor a descent settles: false if the pair is within the tolerance at an end. In
  // order, the interval is looked at further all the same.
  bool fail(PairState& s, std::size_t i) {
    double refused = -1;
    if (!clear(s, i)) {
      refused = w_.grid.parameter(i);
    } else if (!clear(s, i + 1)) {
      refused = w_.grid.parameter(i + 1);
    } else if (plane_settles(s, i) || is_short(s)) {
      if (proofs_ != nullptr) prove(s, i);
      return true;
    }
    if (!ordered_ && refused >= 0) return refuse_at(refused, s.index);
    w_.failures.push_back({i, s.index, refused});
    return true;
  }

  // Whether a pair that is clear at an end cannot meet on an interval, as the bodies travel less than the tolerance.
  bool is_short(const PairState& s) {
    const double way = filters_.speed(s.pair) * w_.grid.step();
    return way + filters_.bulge(s.pair) + 4 * filters_.slack() <= tolerance_;
  }

  bool refuse_at(double parameter, std::int32_t pair) {
    report_.refused = parameter, report_.pair = pair;
    return false;
  }

  // Whether the pair is proved to be more than the tolerance apart at a state; if not, it is within it.
  bool clear(PairState& s, std::size_t state) {
    if ((s.checked >> state & 1U) != 0) return true;
    const double limit = tolerance_ - 2 * filters_.slack();
    if (!is_apart(s, state, limit) && !is_further(s, state, limit)) return false;
    s.checked |= 1U << state;
    return true;
  }

  // The descent ends early where its simplices are flat; before a motion is refused, the proved bound of the distance
  // has the last word.
  bool is_further(PairState& s, std::size_t state, double limit) {
    const PosedPair pose = filters_.posed(s.pair, state);
    if (share_a_point(s, pose)) return false;  // the distance would go on to how deep they are in each other
    const PairDistance found = pair_distance(posed_a(s, pose), posed_b(s, pose), limit, w_.counters.pair);
    if (!(found.lower > limit)) return false;
    s.plane = {w_.motion, pose.frame.from_world(found.direction)};
    s.measured = 0;
    return true;
  }

  // Whether the pair shares a point at a state: no interval there can be settled.
  bool touches(PairState& s, std::size_t state) {
    if (is_apart(s, state, filters_.slack())) return false;
    return share_a_point(s, filters_.posed(s.pair, state));
  }

  PosedBody posed_a(const PairState& s, const PosedPair& pose) { return {&filters_.body(s.pair.a), pose.a}; }
  PosedBody posed_b(const PairState& s, const PosedPair& pose) { return {&filters_.body(s.pair.b), pose.b}; }

  bool share_a_point(const PairState& s, const PosedPair& pose) {
    return test_pair(posed_a(s, pose), posed_b(s, pose), {}, nullptr, w_.counters.pair).shared;
  }

  bool is_apart(PairState& s, std::size_t state, double limit) {
    const PosedPair pose = filters_.posed(s.pair, state);
    return sweep(s, &pose, 1, limit + filters_.swells(s.pair)).reach == Reach::kApart;
  }

  // ----- grids inside grids

  bool judge_grid(const std::vector<std::int32_t>& candidates) {
    const std::size_t base = w_.failures.size();
    w_.open.clear();
    w_.counters.pairs += static_cast<long>(candidates.size());
    for (const std::int32_t index : candidates) {
      const OpenPair found = found_open(index);
      if (found.open != 0) w_.open.push_back(found);
    }
    // The likeliest to collide first: whose boxes are deepest in each other.
    std::sort(w_.open.begin(), w_.open.end(), [](const OpenPair& a, const OpenPair& b) { return a.depth < b.depth; });
    for (const OpenPair& found : w_.open) {
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
      report_.free_until = t[interval];
      Failure first{interval, -1, 2};  // the one that is refused first
      std::vector<std::int32_t> pairs;
      for (; k < failures.size() && failures[k].interval == interval; ++k) {
        if (failures[k].refused >= 0 && failures[k].refused < first.refused) first = failures[k];
        pairs.push_back(failures[k].pair);
      }
      if (first.refused <= t[interval]) return refuse_at(first.refused, first.pair);
      choose(pairs);
      place(t[interval], t[interval + 1], kCut);
      if (!judge_grid(pairs)) return false;
      if (first.pair >= 0) {
        report_.free_until = t[interval + 1];
        return refuse_at(first.refused, first.pair);
      }
    }
    return true;
  }

  void choose(const std::vector<std::int32_t>& pairs) {
    w_.bodies.clear(), w_.frames.clear();
    for (const std::int32_t index : pairs) {
      const CertifiedPair& pair = model_.pairs[at(index)];
      for (const std::int32_t b : {pair.a, pair.b}) {
        if (!filters_.stands_still(b)) w_.bodies.push_back(b);
      }
      if (pair.frame >= 0) w_.frames.push_back(pair.frame);
    }
    w_.grid.choose(w_.bodies, w_.frames);
  }
};

void MotionCertifier::WorkspaceDeleter::operator()(Workspace* workspace) const { delete workspace; }

MotionCertifier::WorkspacePointer MotionCertifier::new_workspace() const {
  return WorkspacePointer(new Workspace(model_));
}

MotionCounters MotionCertifier::take_counters(Workspace& workspace) { return std::exchange(workspace.counters, {}); }

MotionReport MotionCertifier::check(const Kinematics& kinematics, const double* q0, const double* q1, double tolerance,
                                    double kinematic_error, Workspace& workspace) const {
  return MotionRun(*this, kinematics, tolerance, kinematic_error, workspace).run(q0, q1);
}

MotionReport MotionCertifier::explain(const Kinematics& kinematics, const double* q0, const double* q1,
                                      double tolerance, double kinematic_error, std::vector<MotionProof>* proofs,
                                      Workspace& workspace) const {
  MotionRun run(*this, kinematics, tolerance, kinematic_error, workspace);
  run.in_order(proofs);
  return run.run(q0, q1);
}

}  // namespace plannercheck
