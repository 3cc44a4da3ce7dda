#include "motion_certifier.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "motion_grid.hpp"

namespace plannercheck {
namespace {

std::size_t at(std::int32_t index) { return static_cast<std::size_t>(index); }

constexpr std::size_t kStep = static_cast<std::size_t>(kLanes);

// Grids have 2, 4 or 8k states: whole lanes on every instruction set.
constexpr int kIntervals[] = {1, 3, 7, 15, 23, 31};

// The first grid is so fine that no body leaves its chords by more than this, m: coarser ones leave more pairs to the
// costlier tests, finer ones pose more states (measured).
constexpr double kCoarse = 0.02;

// Into how many intervals one is cut that has pairs left: ε shrinks to a ninth.
constexpr int kCut = 3;

// Poses stretch by 1e-6 at most, as the contract says.
constexpr double kStretch = 1 + 2e-6;

// All rounding here (poses of bodies, directions, products, boxes) is some hundred u = 2^-53 of the sizes that enter.
constexpr double kRounding = 0x1p-42, kUnit = 0x1p-53;

// Rounding may take at most this part of the tolerance, else the numbers are too large.
constexpr double kRoundingPart = 1.0 / 16;

double radius(const Body& body) { return (body.radius + body.swell) * kStretch; }

struct Plane {
  bool valid = false;
  Vec3 direction;  // in the pair's frame
};

// A pair that is not settled on an interval; refused: it is within the tolerance at its start.
struct Failure {
  std::size_t interval;
  std::int32_t pair;
  bool refused;
};

// Intervals of a pair that bounds leave open, one bit each; the state at which the boxes' gap along a direction, in the
// frame, is least.
struct OpenPair {
  std::int32_t pair;
  unsigned open;
  double depth;
  std::size_t state;
  Vec3 hint;
};

using Row = std::array<double, kGridRow>;

}  // namespace

class MotionCertifier::Workspace {
 public:
  explicit Workspace(const MotionModel& model)
      : path(at(model.width), model.parts),
        grid(model.bodies, at(model.width), at(model.links)),
        planes(model.pairs.size()) {}

  ConfigurationPath path;
  MotionGrid grid;
  std::vector<Rate> rates;
  std::vector<MotionBound> bounds;  // per chain
  std::vector<std::int32_t> candidates, bodies, frames;
  std::vector<OpenPair> open;
  std::vector<Failure> failures;  // a stack: grids inside grids
  std::vector<Plane> planes;      // per pair
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
        slack_(kinematic_error),
        w_(workspace) {}

  void in_order(std::vector<MotionProof>* proofs) { ordered_ = true, proofs_ = proofs; }

  MotionReport run(const double* q0, const double* q1) {
    begin(q0, q1);
    if (!(slack_ <= kRoundingPart * tolerance_)) return {MotionAnswer::kImprecise, 0, 0, -1};
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
  double tolerance_, slack_, size_ = 0;  // slack: of all rounding; size: of coordinates and arms
  bool ordered_ = false;
  std::vector<MotionProof>* proofs_ = nullptr;
  MotionCertifier::Workspace& w_;
  MotionReport report_;

  // ----- bounds of a pair

  double curvature(std::int32_t chain) const { return chain < 0 ? 0 : w_.bounds[at(chain)].curvature; }
  double speed(std::int32_t chain) const { return chain < 0 ? 0 : w_.bounds[at(chain)].speed; }
  const Body& body(std::int32_t index) const { return *model_.bodies[at(index)].body; }
  bool stands_still(std::int32_t index) const { return model_.bodies[at(index)].link < 0; }

  // ε: how far points may leave their chords within an interval.
  double bulge(double curvature) const { return curvature * w_.grid.step() * w_.grid.step() / 8; }
  double bulge(const CertifiedPair& pair) const { return bulge(curvature(pair.chain_a) + curvature(pair.chain_b)); }

  double swells(const CertifiedPair& pair) const { return (body(pair.a).swell + body(pair.b).swell) * kStretch; }

  // ----- the first grid

  void begin(const double* q0, const double* q1) {
    ++w_.counters.motions;
    w_.failures.clear();
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
    slack_ += rounding(largest, arm);
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

  // The bound of all rounding but that of kinematics: by the sizes of what is computed with; for frames off rigid; for
  // ends off unit length; and for the configurations between them, whose numbers err by at most 8u of the ends', which
  // each joint turns into as much of its arm.
  double rounding(double largest, double arm) {
    double size = certifier_.still_size_;
    for (const std::int32_t mover : certifier_.movers_) {
      const double* c = w_.grid.centre(mover);
      const double around = radius(body(mover)) + body(mover).reach;
      for (std::size_t i = 0; i <= w_.grid.intervals(); ++i) {
        const double far = std::fabs(c[i]) + std::fabs(c[kGridRow + i]) + std::fabs(c[2 * kGridRow + i]);
        size = larger(size, far + around);
      }
    }
    size_ = size + 1 + largest / 8 + arm;
    const double part =
        kRounding + 4 * model_.defect + 8 * w_.path.off_unit() + 16 * kUnit * model_.leverage * (1 + w_.path.largest());
    return part * size_;
  }

  // ----- bounds in lanes: a bit for each interval that they do not settle

  unsigned all_intervals() const { return (1U << w_.grid.intervals()) - 1; }

  // Pairs of which the boxes around both bodies' whole paths meet, and pairs of two bodies that move.
  void find_candidates() {
    w_.candidates = certifier_.among_self_;
    const std::size_t row = certifier_.still_row_;
    const double* bounds = certifier_.still_bounds_.data();
    for (std::size_t m = 0; m < certifier_.movers_.size(); ++m) {
      if (certifier_.chain_in_world_[m] < 0) continue;
      const std::array<Lanes, 6> box = box_around_path(m);
      for (std::size_t first = 0; first < row; first += kStep) {
        LaneMask apart{};
        for (std::size_t k = 0; k < 3; ++k) {
          apart |= load_lanes(bounds + k * row + first) > box[k + 3];
          apart |= load_lanes(bounds + (k + 3) * row + first) < box[k];
        }
        for (unsigned meet = ~bits(apart) & ((1U << kLanes) - 1); meet != 0; meet &= meet - 1) {
          const std::size_t still = first + static_cast<std::size_t>(__builtin_ctz(meet));
          if (const std::int32_t pair = certifier_.pair_of_[m * row + still]; pair >= 0) w_.candidates.push_back(pair);
        }
      }
    }
  }

  // Low and high corners, broadcast: the centre leaves its chords by at most ε.
  std::array<Lanes, 6> box_around_path(std::size_t m) const {
    const std::int32_t mover = certifier_.movers_[m];
    const double grown = radius(body(mover)) + bulge(curvature(certifier_.chain_in_world_[m])) + slack_;
    std::array<Lanes, 6> box;
    for (std::size_t k = 0; k < 3; ++k) {
      const double* row = w_.grid.centre(mover) + k * kGridRow;
      const auto [low, high] = std::minmax_element(row, row + w_.grid.intervals() + 1);
      box[k] = broadcast(*low - grown);
      box[k + 3] = broadcast(*high + grown);
    }
    return box;
  }

  unsigned near(const CertifiedPair& pair) {
    const double apart = radius(body(pair.a)) + bulge(pair) + slack_;
    if (stands_still(pair.b)) {
      // The transpose of a placement that is off rigid, in place of its inverse.
      const double turned = 2 * certifier_.defects_[at(pair.b)] * size_;
      return chord_meets_box(pair, apart + body(pair.b).swell * kStretch + turned);
    }
    const double sum = apart + radius(body(pair.b));
    return spheres_come_near(pair, sum) ? chord_meets_sphere(pair, sum) : 0;
  }

  // The sphere around a on the chord of its centre, against b's box in b's frame.
  unsigned chord_meets_box(const CertifiedPair& pair, double apart) const {
    const Body& b = body(pair.b);
    const auto& m = model_.bodies[at(pair.b)].placement.m;
    const double* c = w_.grid.centre(pair.a);
    std::array<Row, 3> seen;
    for (std::size_t i = 0; i <= w_.grid.intervals(); i += kStep) {
      const Lanes x = load_lanes(c + i) - m[3], y = load_lanes(c + kGridRow + i) - m[7],
                  z = load_lanes(c + 2 * kGridRow + i) - m[11];
      for (std::size_t k = 0; k < 3; ++k) store_lanes(&seen[k][i], (m[k] * x + m[k + 4] * y) + m[k + 8] * z);
    }
    unsigned open = 0;
    for (std::size_t i = 0; i < w_.grid.intervals(); i += kStep) {
      Lanes square{};
      for (std::size_t k = 0; k < 3; ++k) {
        const Lanes from = load_lanes(&seen[k][i]), to = load_lanes(&seen[k][i + 1]);
        const Lanes low = from < to ? from : to, high = larger(from, to);
        const Lanes beyond =
            larger(Lanes{}, larger(b.low[static_cast<int>(k)] - high, low - b.high[static_cast<int>(k)]));
        square = square + beyond * beyond;
      }
      open |= bits(square <= broadcast(apart * apart)) << i;
    }
    return open & all_intervals();
  }

  // Whether the spheres' distance at the states allows them to meet between: the centres approach at most at the
  // speed of both, seen from the frame.
  bool spheres_come_near(const CertifiedPair& pair, double sum) const {
    const double *a = w_.grid.centre(pair.a), *b = w_.grid.centre(pair.b);
    Lanes least = broadcast(std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i <= w_.grid.intervals(); i += kStep) {
      Lanes square{};
      for (std::size_t k = 0; k < 3; ++k) {
        const Lanes d = load_lanes(a + k * kGridRow + i) - load_lanes(b + k * kGridRow + i);
        square = square + d * d;
      }
      least = least < square ? least : square;
    }
    const double reach = sum + (speed(pair.chain_a) + speed(pair.chain_b)) * w_.grid.step() / 2;
    return bits(least <= broadcast(reach * reach)) != 0;
  }

  // With c the difference of the centres in the middle of a chord and d that of its ends, the distance along the chord
  // is at least √(c·c − |c·d|).
  unsigned chord_meets_sphere(const CertifiedPair& pair, double sum) const {
    const double *a = w_.grid.centre(pair.a), *b = w_.grid.centre(pair.b);
    std::array<Row, 3> seen;
    for (std::size_t i = 0; i <= w_.grid.intervals(); i += kStep) {
      std::array<Lanes, 3> d;
      for (std::size_t k = 0; k < 3; ++k) d[k] = load_lanes(a + k * kGridRow + i) - load_lanes(b + k * kGridRow + i);
      if (pair.frame >= 0) d = turned_back(w_.grid.link(pair.frame) + i, d);
      for (std::size_t k = 0; k < 3; ++k) store_lanes(&seen[k][i], d[k]);
    }
    unsigned open = 0;
    for (std::size_t i = 0; i < w_.grid.intervals(); i += kStep) {
      Lanes square{}, along{};
      for (std::size_t k = 0; k < 3; ++k) {
        const Lanes from = load_lanes(&seen[k][i]), to = load_lanes(&seen[k][i + 1]), middle = 0.5 * (from + to);
        square = square + middle * middle;
        along = along + middle * (to - from);
      }
      open |= bits(square - absolute(along) <= broadcast(sum * sum)) << i;
    }
    return open & all_intervals();
  }

  // A vector of the world seen from a frame, whose pose begins at `rows`.
  static std::array<Lanes, 3> turned_back(const double* rows, const std::array<Lanes, 3>& v) {
    std::array<Lanes, 3> out;
    for (std::size_t k = 0; k < 3; ++k) {
      out[k] = (load_lanes(rows + k * kGridRow) * v[0] + load_lanes(rows + (k + 4) * kGridRow) * v[1]) +
               load_lanes(rows + (k + 8) * kGridRow) * v[2];
    }
    return out;
  }

  // A direction of the frame in the world.
  std::array<Lanes, 3> turned(std::int32_t frame, std::size_t first, Vec3 d) const {
    if (frame < 0) return {broadcast(d.x), broadcast(d.y), broadcast(d.z)};
    const double* rows = w_.grid.link(frame) + first;
    std::array<Lanes, 3> out;
    for (std::size_t k = 0; k < 3; ++k) {
      const double* r = rows + 4 * k * kGridRow;
      out[k] = (load_lanes(r) * d.x + load_lanes(r + kGridRow) * d.y) + load_lanes(r + 2 * kGridRow) * d.z;
    }
    return out;
  }

  // Settles what the bodies' boxes do along a direction of the frame, and says where they are deepest in each other.
  void boxes_settle(OpenPair& found, Vec3 direction) {
    const CertifiedPair& pair = model_.pairs[at(found.pair)];
    Row gaps;
    for (std::size_t i = 0; i <= w_.grid.intervals(); i += kStep) {
      const auto d = turned(pair.frame, i, direction);
      store_lanes(&gaps[i], least_of_box(pair.a, i, d) + least_of_box(pair.b, i, {-d[0], -d[1], -d[2]}));
    }
    const Lanes limit = broadcast(apart(pair));
    for (std::size_t i = 0; i < w_.grid.intervals(); i += kStep) {
      const Lanes from = load_lanes(&gaps[i]), to = load_lanes(&gaps[i + 1]), least = from < to ? from : to;
      found.open &= ~((bits(least > limit) & ((1U << kLanes) - 1)) << i);
    }
    const auto deepest =
        std::min_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(w_.grid.intervals()) + 1);
    found.depth = *deepest;
    found.state = static_cast<std::size_t>(deepest - gaps.begin());
  }

  // The least product of a direction with a point of a body's box.
  Lanes least_of_box(std::int32_t index, std::size_t first, const std::array<Lanes, 3>& d) {
    const Body& b = body(index);
    const Vec3 middle = 0.5 * (b.low + b.high), half = 0.5 * (b.high - b.low);
    std::array<Lanes, 12> m;
    if (stands_still(index)) {
      for (std::size_t k = 0; k < 12; ++k) m[k] = broadcast(model_.bodies[at(index)].placement.m[k]);
    } else {
      const double* rows = w_.grid.poses(index) + first;
      for (std::size_t k = 0; k < 12; ++k) m[k] = load_lanes(rows + k * kGridRow);
    }
    Lanes sum = (d[0] * m[3] + d[1] * m[7]) + d[2] * m[11];
    for (std::size_t k = 0; k < 3; ++k) {
      const Lanes along = (d[0] * m[k] + d[1] * m[k + 4]) + d[2] * m[k + 8];
      sum = sum + (along * middle[static_cast<int>(k)] - absolute(along) * half[static_cast<int>(k)]);
    }
    return sum;
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

  PosedPair posed(const CertifiedPair& pair, std::size_t state) {
    return {w_.grid.pose(pair.a, state), w_.grid.pose(pair.b, state), w_.grid.turn(pair.frame, state)};
  }

  // Settles the intervals of a pair or notes them down as failures; false if the pair is within the tolerance.
  bool settle(const OpenPair& found) {
    const CertifiedPair& pair = model_.pairs[at(found.pair)];
    PairState s{pair, found.pair, apart(pair), w_.planes[at(found.pair)], 0, 0, {}};
    if (!s.plane.valid) s.plane = {true, found.hint};
    if (!ordered_ && found.depth < 0 && !clear(s, found.state)) return refuse(found.state, found.pair), false;
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

  // More than this, along a direction at both ends of an interval, settles it.
  double apart(const CertifiedPair& pair) const { return bulge(pair) + swells(pair) + slack_; }

  // What spheres and boxes leave open of a pair: along the plane of last time, and along a direction that they suggest.
  OpenPair found_open(std::int32_t index) {
    const CertifiedPair& pair = model_.pairs[at(index)];
    const Plane& plane = w_.planes[at(index)];
    OpenPair found{index, proofs_ != nullptr ? all_intervals() : near(pair), 0, 0, {}};
    w_.counters.intervals += __builtin_popcount(found.open);
    if (found.open != 0 && plane.valid && proofs_ == nullptr) boxes_settle(found, plane.direction);
    if (found.open == 0) return found;
    found.hint = between(pair, static_cast<std::size_t>(__builtin_ctz(found.open)));
    if (proofs_ == nullptr) boxes_settle(found, found.hint);
    return found;
  }

  void prove(PairState& s, std::size_t i) {
    const double least = smaller(gap(s, i), gap(s, i + 1)) - swells(s.pair) - slack_;
    proofs_->push_back(
        {s.index, w_.grid.parameter(i), w_.grid.parameter(i + 1), s.plane.direction, least, bulge(s.pair)});
  }

  bool plane_settles(PairState& s, std::size_t i) { return gap(s, i) > s.apart && gap(s, i + 1) > s.apart; }

  double gap(PairState& s, std::size_t state) {
    if ((s.measured >> state & 1U) == 0) {
      s.measured |= 1U << state;
      ++w_.counters.planes;
      s.gaps[state] =
          gap_along(body(s.pair.a), body(s.pair.b), posed(s.pair, state), s.plane.direction, w_.counters.pair);
    }
    return s.gaps[state];
  }

  bool sweep_settles(PairState& s, std::size_t i) {
    const std::array<PosedPair, 2> ends{posed(s.pair, i), posed(s.pair, i + 1)};
    const SweptAnswer answer = sweep(s, ends.data(), 2, s.apart);
    return answer.reach == Reach::kApart;
  }

  SweptAnswer sweep(PairState& s, const PosedPair* poses, int count, double apart) {
    ++w_.counters.swept;
    const SweptAnswer answer =
        swept_distance(body(s.pair.a), body(s.pair.b), poses, count, apart, s.plane.direction, w_.counters.pair);
    s.plane = {true, answer.direction};
    s.measured = 0;
    return answer;
  }

  // From b to a, in the frame: the way out of b's box if a's centre is outside, else between the centres.
  Vec3 between(const CertifiedPair& pair, std::size_t state) {
    const PosedPair p = posed(pair, state);
    const Body &a = body(pair.a), &b = body(pair.b);
    const Vec3 c = p.b.rotate_back(p.a.apply(a.centre) - p.b.translation());
    const auto beyond = [](double x, double low, double high) { return x < low ? x - low : x > high ? x - high : 0; };
    Vec3 d{beyond(c.x, b.low.x, b.high.x), beyond(c.y, b.low.y, b.high.y), beyond(c.z, b.low.z, b.high.z)};
    if (norm_1(d) == 0) d = c - b.centre;
    const double length = norm(d);
    return length > 0 ? p.frame.from_world(p.b.rotate((1 / length) * d)) : Vec3{1, 0, 0};
  }

  // An interval that nothing settles: false if the pair is within the tolerance at its ends, or the interval so short
  // that it is within the tolerance all the way.
  bool fail(PairState& s, std::size_t i) {
    const double way = (speed(s.pair.chain_a) + speed(s.pair.chain_b)) * w_.grid.step();
    const bool short_enough = way + bulge(s.pair) + 2 * slack_ <= tolerance_;
    const bool refused = short_enough || !clear(s, i);
    if (!ordered_ && (refused || !clear(s, i + 1))) {
      refuse(refused ? i : i + 1, s.index);
      return false;
    }
    w_.failures.push_back({i, s.index, refused});
    return true;
  }

  void refuse(std::size_t state, std::int32_t pair) { refuse_at(w_.grid.parameter(state), pair); }
  void refuse_at(double parameter, std::int32_t pair) { report_.refused = parameter, report_.pair = pair; }

  // Whether the pair is proved to be more than the tolerance apart at a state; if not, it is within it.
  bool clear(PairState& s, std::size_t state) {
    if ((s.checked >> state & 1U) != 0) return true;
    const PosedPair pose = posed(s.pair, state);
    const double limit = tolerance_ - 2 * slack_ + swells(s.pair);
    if (sweep(s, &pose, 1, limit).reach != Reach::kApart) return false;
    s.checked |= 1U << state;
    return true;
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
      std::vector<std::int32_t> pairs;
      for (; k < failures.size() && failures[k].interval == interval; ++k) {
        if (failures[k].refused) return refuse_at(t[interval], failures[k].pair), false;
        pairs.push_back(failures[k].pair);
      }
      choose(pairs);
      place(t[interval], t[interval + 1], kCut);
      if (!judge_grid(pairs)) return false;
    }
    return true;
  }

  void choose(const std::vector<std::int32_t>& pairs) {
    w_.bodies.clear(), w_.frames.clear();
    for (const std::int32_t index : pairs) {
      const CertifiedPair& pair = model_.pairs[at(index)];
      for (const std::int32_t b : {pair.a, pair.b}) {
        if (!stands_still(b)) w_.bodies.push_back(b);
      }
      if (pair.frame >= 0) w_.frames.push_back(pair.frame);
    }
    w_.grid.choose(w_.bodies, w_.frames);
  }
};

MotionCertifier::MotionCertifier(MotionModel model) : model_(std::move(model)) {
  std::vector<bool> used(model_.bodies.size(), false);
  for (std::size_t p = 0; p < model_.pairs.size(); ++p) {
    const CertifiedPair& pair = model_.pairs[p];
    used[at(pair.a)] = used[at(pair.b)] = true;
    if (pair.frame >= 0) frames_.push_back(pair.frame);
    if (model_.bodies[at(pair.b)].link >= 0) among_self_.push_back(static_cast<std::int32_t>(p));
  }
  for (std::size_t b = 0; b < used.size(); ++b) {
    if (used[b]) (model_.bodies[b].link >= 0 ? movers_ : still_).push_back(static_cast<std::int32_t>(b));
  }
  for (const MountedBody& body : model_.bodies) defects_.push_back(rigidity_defect(body.placement) + 16 * kUnit);
  bound_still();
}

void MotionCertifier::bound_still() {
  still_row_ = (still_.size() + kStep - 1) / kStep * kStep;
  still_bounds_.assign(6 * still_row_, std::numeric_limits<double>::infinity());
  std::vector<std::int32_t> position(model_.bodies.size(), -1);
  for (std::size_t s = 0; s < still_.size(); ++s) {
    const MountedBody& mounted = model_.bodies[at(still_[s])];
    position[at(still_[s])] = static_cast<std::int32_t>(s);
    const double far = norm_1(mounted.placement.translation()) + mounted.body->reach * kStretch;
    still_size_ = larger(still_size_, far + mounted.body->reach + 2 * radius(*mounted.body));
    for (std::size_t k = 0; k < 3; ++k) {
      double &low = still_bounds_[k * still_row_ + s], &high = still_bounds_[(k + 3) * still_row_ + s];
      high = -low;
      for (const Vec3& v : mounted.body->inner.points) {
        const Vec3 p = mounted.placement.apply(v);
        low = smaller(low, p[static_cast<int>(k)]), high = larger(high, p[static_cast<int>(k)]);
      }
      low -= mounted.body->swell, high += mounted.body->swell;
    }
  }
  pair_of_.assign(movers_.size() * still_row_, -1);
  chain_in_world_.assign(movers_.size(), -1);
  for (std::size_t p = 0; p < model_.pairs.size(); ++p) {
    const CertifiedPair& pair = model_.pairs[p];
    if (position[at(pair.b)] < 0) continue;
    const auto m = static_cast<std::size_t>(std::lower_bound(movers_.begin(), movers_.end(), pair.a) - movers_.begin());
    pair_of_[m * still_row_ + at(position[at(pair.b)])] = static_cast<std::int32_t>(p);
    chain_in_world_[m] = pair.chain_a;
  }
}

MotionCertifier::~MotionCertifier() = default;

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

void MotionCertifier::states(const double* q0, const double* q1, const double* t, std::size_t n, double* q) const {
  ConfigurationPath path(at(model_.width), model_.parts);
  path.set(q0, q1);
  std::vector<double> columns(at(model_.width) * n);
  path.at(t, n, n, columns.data());
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < at(model_.width); ++c) q[i * at(model_.width) + c] = columns[c * n + i];
  }
}

}  // namespace plannercheck
