// The check of a motion in space: the Run of adaptive_subdivision.hpp.
//
// In: a certifier, a workspace, a motion. Out: a report. The bounds of the motion determine the first grid, and boxes
// around whole paths choose the pairs for it. What is asked of a pair is in motion_pairs.hpp.
#include <algorithm>
#include <numeric>
#include <utility>

#include "motions/motion_certifier.hpp"
#include "motions/motion_pairs.hpp"
#include "motions/motion_rounding.hpp"
#include "motions/motion_workspace.hpp"

namespace plannercheck {
namespace {

// The first grid is so fine that no body leaves its chords by more than this, m. Coarser grids leave more pairs to the
// costlier tests, finer ones pose more states. Up to eight states are posed at once and cost little more than one, so
// the bound is tighter there (measured).
constexpr double kCoarse = 0.02, kCoarseAtOnce = 0.002;
constexpr int kIntervalsAtOnce = 7;

// Curves are cut no shorter than this part of their length.
constexpr double kShortestCut = 1.0 / 64;

int intervals_for(double curvature) {
  const int few = first_intervals(curvature, kCoarseAtOnce);
  return few <= kIntervalsAtOnce ? few : std::max(kIntervalsAtOnce, first_intervals(curvature, kCoarse));
}

// Rounding may take at most this part of the tolerance; beyond, the numbers are too large.
constexpr double kRoundingPart = 1.0 / 16;

}  // namespace

class MotionRun : private MotionPairs {
 public:
  MotionRun(const MotionCertifier& certifier, const Kinematics& kinematics, double tolerance, double kinematic_error,
            MotionCertifier::Workspace& workspace)
      : MotionPairs(certifier, kinematics, tolerance, workspace), kinematic_error_(kinematic_error) {}

  using MotionPairs::in_order;

  // For a motion that surely collides at a state.
  MotionAnswer refused_or_imprecise(const Segment& motion) {
    begin_motion(motion);
    set_rounding(certifier_.chain_table_->at_most(w_.rates));
    if (is_precise()) return MotionAnswer::kRefused;
    bound();
    return is_precise() ? MotionAnswer::kRefused : MotionAnswer::kImprecise;
  }

  MotionReport run(const Segment& motion) {
    begin_motion(motion);
    bound();
    if (!is_precise()) return {MotionAnswer::kImprecise, 0, 0, -1};
    const bool is_free = w_.path.is_curve() ? judge_curve(0, 1) : judge_on_grid(0, 1, intervals(1));
    report_.answer = is_free ? MotionAnswer::kFree : MotionAnswer::kRefused;
    return report_;
  }

 private:
  double kinematic_error_;

  void begin_motion(const Segment& motion) {
    w_.begin_motion();
    w_.path.set(motion, tuning_.thin_tubes);
    rates_of(model_.chains, w_.path, w_.rates);
  }

  void bound() {
    bound_chains();
    if (w_.path.has_tube()) {
      tube_rates_of(model_.chains, w_.path, w_.tube_rates);
      certifier_.chain_table_->bound_tube(model_.chains, w_.tube_rates, w_.path.room(), w_.tube_bounds);
    }
    w_.bounds.set_tube(w_.path.has_tube() ? &w_.tube_bounds : nullptr);
    set_rounding(w_.bounds.largest());
  }
  void bound_chains() { certifier_.chain_table_->bound(model_.chains, w_.rates, w_.bounds); }

  void set_rounding(const MotionBound& largest) {
    const double extent = certifier_.still_size_ + certifier_.mounted_size_;
    filters_.set_rounding(motion_rounding(model_, extent, w_.path, largest, kinematic_error_));
  }

  bool is_precise() const { return filters_.slack() <= kRoundingPart * tolerance_; }

  // How many intervals the grid of a part of the motion needs, by the bounds that hold there.
  int intervals(double length) const { return intervals_for(w_.bounds.largest().curvature * length * length); }

  // Judges an interval of a curve, in halves where one grid of few states would be too coarse: each half then has
  // bounds of its own, and not those of the part where the speed changes most.
  bool judge_curve(double from, double to) {
    const double length = to - from;
    if (length < 1) {
      ++w_.motion;  // planes of other intervals are hints
      w_.path.look_at(from, to);
      rates_of(model_.chains, w_.path, w_.rates);
      bound_chains();
    }
    if (tuning_.halves && intervals(length) > kIntervalsAtOnce && length > kShortestCut) {
      const double middle = (from + to) / 2;
      return judge_curve(from, middle) && judge_curve(middle, to);
    }
    return judge_on_grid(from, to, intervals(length));
  }

  // An interval of the motion by a grid of its own.
  bool judge_on_grid(double from, double to, int intervals) {
    begin();
    place(from, to, intervals);
    if (proofs_ != nullptr) {
      w_.candidates.resize(model_.pairs.size());
      std::iota(w_.candidates.begin(), w_.candidates.end(), 0);
    } else {
      find_candidates();
    }
    if (!judge_grid(w_.candidates)) return false;
    report_.free_until = to;
    return true;
  }

  void begin() {
    if (w_.prepared_for != kinematics_.id()) {
      w_.all = w_.grid.choice(kinematics_, certifier_.movers_, certifier_.frames_);
      w_.prepared_for = kinematics_.id();
    }
    posed_ = &w_.all;
  }

  // In order, `free_until` may depend on pairs that the bounds of speed would leave out.
  void find_candidates() {
    if (tuning_.bounds && !ordered_) {
      certifier_.screen_->find_by_speeds(w_.grid, filters_, w_.bounds, 2 * tolerance_, w_.screen, w_.candidates);
    } else {
      certifier_.screen_->find_by_paths(filters_, w_.candidates);
    }
  }
};

std::shared_ptr<MotionCertifier::Workspace> MotionCertifier::new_workspace() const {
  auto workspace = std::make_shared<Workspace>(model_);
  if (states_ != nullptr) workspace->states = states_->new_workspace();
  return workspace;
}

MotionCounters MotionCertifier::take_counters(Workspace& workspace) { return std::exchange(workspace.counters, {}); }

void MotionCertifier::check(const Kinematics& kinematics, const Segments& motions, std::size_t n, double tolerance,
                            double kinematic_error, std::uint8_t* answers, Workspace& w) const {
  for (std::size_t first = 0; first < n; first += kMotionsAtOnce) {
    const std::size_t count = std::min(kMotionsAtOnce, n - first);
    const Segments some = motions.from(first);
    judge_states(kinematics, some, count, w);
    for (std::size_t i = 0; i < count; ++i) {
      if (first + i > 0) poll_interruption();
      MotionRun run(*this, kinematics, tolerance, kinematic_error, w);
      answers[first + i] =
          static_cast<std::uint8_t>(w.is_free[i] == 0 ? run.refused_or_imprecise(some[i]) : run.run(some[i]).answer);
    }
  }
}

void MotionCertifier::check_pieces(const Kinematics& kinematics, const Segments& pieces, std::size_t n,
                                   double tolerance, double kinematic_error, const PoseRange& range,
                                   std::uint8_t* answers, Workspace& w) const {
  const bool are_covered = tuning_.covers && pieces.tubes != nullptr && model_.parts.empty();
  w.covers.find(pieces, are_covered ? n : 0, at(model_.width), tolerance, range);
  const auto check_some = [&](std::size_t first, std::size_t past) {
    check(kinematics, pieces.from(first), past - first, tolerance, kinematic_error, answers + first, w);
  };
  const std::size_t covers = w.covers.size();
  if (covers == 0) return check_some(0, n);
  w.cover_answers.resize(covers);
  check(kinematics, w.covers.motions(), covers, tolerance, kinematic_error, w.cover_answers.data(), w);
  std::size_t judged = 0;
  for (std::size_t k = 0; k < covers; ++k) {
    if (w.cover_answers[k] != static_cast<std::uint8_t>(MotionAnswer::kFree)) continue;
    const std::size_t first = w.covers.first(k), past = w.covers.past(k);
    check_some(judged, first);
    std::fill(answers + first, answers + past, static_cast<std::uint8_t>(MotionAnswer::kFree));
    judged = past;
  }
  check_some(judged, n);
}

MotionReport MotionCertifier::explain(const Kinematics& kinematics, const Segment& motion, double tolerance,
                                      double kinematic_error, std::vector<MotionProof>* proofs,
                                      Workspace& workspace) const {
  MotionRun run(*this, kinematics, tolerance, kinematic_error, workspace);
  run.in_order(proofs);
  return run.run(motion);
}

}  // namespace plannercheck
