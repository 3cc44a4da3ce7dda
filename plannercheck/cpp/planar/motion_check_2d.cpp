// The check of a motion in the plane: the Run of adaptive_subdivision.hpp.
//
// In: a certifier, a workspace, a motion of pieces. Out: a report. The pieces are checked in order, each with its own
// grids, all pairs on the first one; a pair passes circles on chords against boxes or other circles.
#include <algorithm>
#include <cmath>
#include <utility>

#include "math/vec.hpp"
#include "motions/adaptive_subdivision.hpp"
#include "planar/motion_certifier_2d.hpp"
#include "planar/motion_filters_2d.hpp"
#include "planar/motion_grid_2d.hpp"

namespace plannercheck {
namespace {

// The first grid is so fine that no body leaves its chords by more than this, m (measured).
constexpr double kPlanarCoarse = 0.05;

// Rounding and a piece's slip may take at most this part of the tolerance, as intervals can only become short enough if
// twice as much is less than the tolerance. If rounding takes more, the numbers are too large; if a slip does, the
// piece is checked with a greater tolerance.
constexpr double kPlanarRoundingPart = 1.0 / 4;

}  // namespace

// The Space of adaptive_subdivision.hpp.
struct PlanarMotions {
  using Pair = PlanarMotionPair;
  using Poses = PlanarPlaces;
  using Direction = PlanarDirection;
  using Grid = PlanarGrid;
  using Open = OpenPair;
  using Counters = GridCounters;
  using Workspace = PlanarCertifier::Workspace;
};

struct PlanarCertifier::Workspace : SubdivisionWorkspace<PlanarMotions> {
  Workspace(const std::vector<PlanarLink>& links, std::size_t width, const std::vector<PlanarGeometryObject>& bodies,
            const std::vector<std::int32_t>& movers, std::size_t pairs)
      : SubdivisionWorkspace(PlanarGrid(links, width, bodies, movers), pairs),
        rates(width),
        bounds(pairs),
        all(indices_below(pairs)) {}

  std::vector<double> rates;
  std::vector<PlanarBound> bounds;  // per pair, of both bodies together
  std::vector<std::int32_t> all;
};

class PlanarRun : public AdaptiveSubdivision<PlanarRun, PlanarMotions> {
 public:
  PlanarRun(const PlanarCertifier& certifier, const PlanarMotion& motion, double tolerance,
            PlanarCertifier::Workspace& workspace)
      : AdaptiveSubdivision(certifier.pairs_, workspace),
        certifier_(certifier),
        motion_(motion),
        given_tolerance_(tolerance) {}

  MotionReport run() {
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
  friend AdaptiveSubdivision;

  const PlanarCertifier& certifier_;
  const PlanarMotion& motion_;
  double given_tolerance_, tolerance_ = 0;
  const PlanarPiece* piece_ = nullptr;
  double slack_ = 0, way_ = 0;  // the root's on the piece, m

  // ----- a piece's first grid

  void begin(const PlanarPiece& piece) {
    piece_ = &piece;
    way_ = norm_above({piece.way_x, piece.way_y, 0}) * (1 + 0x1p-40);
    for (std::size_t c = 0; c < w_.rates.size(); ++c)
      w_.rates[c] = (piece.to - piece.from) * (motion_.q1[c] - motion_.q0[c]);
    if (certifier_.links_[0].joint == PlanarJoint::kFree) w_.rates[2] = piece.turn;
    double largest = 0;
    for (std::size_t p = 0; p < w_.bounds.size(); ++p) {
      const PlanarMotionPair& pair = pairs_[p];
      const PlanarBound a = planar_bound(pair.chain_a, piece, w_.rates);
      const PlanarBound b = planar_bound(pair.chain_b, piece, w_.rates);
      const double slide = pair.frame < 0 ? way_ : 0;
      w_.bounds[p] = {a.curvature + b.curvature, a.speed + b.speed + slide};
      largest = larger(largest, w_.bounds[p].curvature);
    }
    place(0, 1, first_intervals(largest, kPlanarCoarse));
  }

  void pose_grid(double from, double to, int intervals) {
    w_.grid.place(motion_.q0, motion_.q1, *piece_, from, to, intervals);
  }

  // The motion's parameter of a state.
  double parameter(double s) const { return s >= 1 ? piece_->to : piece_->from + s * (piece_->to - piece_->from); }

  // ----- what is known of a pair on the grid

  const PlanarGeometryObject& body(std::int32_t index) const { return certifier_.bodies_[at(index)]; }
  const PlanarHull& hull(std::int32_t index) const { return certifier_.hulls_[at(index)]; }
  double chord_deviation(std::int32_t pair) const {
    return w_.bounds[at(pair)].curvature * w_.grid.step() * w_.grid.step() / 8;
  }
  // An interval is settled if the gap along one direction exceeds this at both ends.
  double apart(std::int32_t pair) const { return chord_deviation(pair) + slack_; }

  PlanarPlaces poses(const PlanarMotionPair& pair, std::size_t state) const {
    return {w_.grid.place_of(body(pair.a).link, state), w_.grid.place_of(body(pair.b).link, state),
            w_.grid.place_of(pair.frame, state)};
  }

  // ----- circles and boxes

  OpenPair found_open(std::int32_t index, unsigned near) const {
    const PlanarMotionPair& pair = pairs_[at(index)];
    const bool still = body(pair.b).link < 0;
    OpenPair found{index, near, HUGE_VAL, 0};
    for (unsigned open = found.open | found.open << 1; open != 0; open &= open - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(open));
      const PlanarVector v = between(pair, i);
      const double depth = std::sqrt(v.x * v.x + v.y * v.y) - body(pair.a).radius - (still ? 0 : body(pair.b).radius);
      if (depth < found.depth) found.depth = depth, found.state = i;
    }
    return found;
  }

  unsigned near(std::int32_t index) const {
    const PlanarMotionPair& pair = pairs_[at(index)];
    const PlanarGeometryObject &a = body(pair.a), &b = body(pair.b);
    if (b.link < 0) return chords_meet_box(w_.grid, pair.a, b.box, a.radius + apart(index));
    const double moved = w_.bounds[at(index)].speed * w_.grid.step() / 2;
    return centres_come_near(w_.grid, pair.a, pair.b, a.radius + b.radius + slack_ + moved);
  }

  // The vector from the nearest point of b's box, or from b's centre, to a's centre.
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

  PlanarDirection first_direction(const OpenPair& found) const {
    const PlanarMotionPair& pair = pairs_[at(found.pair)];
    return PlanarDirection::along(w_.grid.place_of(pair.frame, found.state).turned_back(between(pair, found.state)));
  }

  double gap_at(const PlanarMotionPair& pair, const PlanarPlaces& places, PlanarDirection direction) const {
    return planar_gap(hull(pair.a), hull(pair.b), places, direction);
  }

  SweptAnswer<PlanarDirection> swept(const PlanarMotionPair& pair, const PlanarPlaces* places, int count, double limit,
                                     PlanarDirection hint) const {
    return planar_apart(hull(pair.a), hull(pair.b), places, count, limit, hint);
  }

  PlanarProof proof(const PairState& s, double from, double to, double least) const {
    return {s.index, parameter(from), parameter(to), s.plane.direction, least - slack_, chord_deviation(s.index)};
  }

  // An interval is refused if it is so short that a pair which nothing settles is within the tolerance throughout.
  bool fail(PairState& s, std::size_t i) {
    const double way = w_.bounds[at(s.index)].speed * w_.grid.step();
    const bool is_short = way + chord_deviation(s.index) + 2 * slack_ <= tolerance_;
    return leave(s, i, is_short ? w_.grid.parameter(i) : end_within(s, i));
  }

  bool touches(PairState& s, std::size_t state) { return !sweep_at(s, state, slack_).apart; }
  bool proves_clear(PairState& s, std::size_t state) { return sweep_at(s, state, tolerance_ - 2 * slack_).apart; }
};

std::shared_ptr<PlanarCertifier::Workspace> PlanarCertifier::new_workspace() const {
  return std::make_shared<Workspace>(links_, width_, bodies_, movers_, pairs_.size());
}

GridCounters PlanarCertifier::take_counters(Workspace& workspace) { return std::exchange(workspace.counters, {}); }

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
