#include "broad_phase/broad_phase.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "broad_phase/pairs_by_state.hpp"

namespace plannercheck {
namespace {

// From this many states on, lanes over states beat lanes over obstacles and pairs' boxes one by one (measured).
constexpr int kFewStates = 3;

// In place of a configuration's numbers where only poses are given: no cell is known, then.
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

void BroadPhase::clear_near(Workspace& w) {
  for (; w.undecided != 0; w.undecided &= w.undecided - 1) {
    w.near[static_cast<std::size_t>(__builtin_ctz(w.undecided))].clear();
  }
}

void BroadPhase::begin(Workspace& w) {
  clear_near(w);
  w.candidates.clear(), w.unboxed.clear();
  w.tested = 0;
  w.boxed = false;
  w.boxes_apart = w.skipped = 0;
  w.overlapping = 0;
  w.overlap = LikelyOverlaps::kNone;
  w.boxes.begin(), w.overlaps.begin();
}

void BroadPhase::find(const Lanes* links, BlockConfigurations q, int count, Filters filters, Workspace& w) const {
  begin(w);
  if (filters.overlaps && !permanent_pairs_.empty()) return take_overlapping(count, w);
  w.boxed = filters.boxes && count >= kFewStates;
  w.links.begin(links);
  w.are_fixed = false;
  if (count < kFewStates) {
    for (std::size_t state = 0; state < static_cast<std::size_t>(count); ++state) {
      const auto value = [&](std::size_t column) { return q.are_known() ? q.value(column, state) : kUnknown; };
      find_for_state(links_in_state(links, state, w), value, state, w);
    }
  } else {
    find_for_block(q, count, filters, w);
  }
  filter(count, filters, w);
}

void BroadPhase::find(const FloatPose* links, const PoseError* errors, std::uint64_t posed_by, BlockConfigurations q,
                      int count, Filters filters, Workspace& w) const {
  begin(w);
  if (posed_by != 0 && w.fixed.posed_by != posed_by) fix_radii(errors, w.fixed), w.fixed.posed_by = posed_by;
  w.are_fixed = posed_by != 0;
  if (filters.overlaps && !permanent_pairs_.empty()) return take_overlapping(count, w);
  w.boxed = filters.boxes && count >= kFewStates;
  w.links.begin(links, errors);
  const std::size_t expected = std::exchange(w.overlap_at_end, LikelyOverlaps::kNone);
  if (filters.overlaps && filters.learning && expected != LikelyOverlaps::kNone) {
    // An overlap is a proof, as for one state.
    const unsigned states = (1U << count) - 1, found = overlap(expected, w) & states;
    take_overlap(expected, found, count, w);
    if (found == states) return take_overlapping(count, w);
    w.skipped = __builtin_popcount(found) * (static_cast<long>(pairs_.size()) - 1);
  }
  find_for_block(q, count, filters, w);
  filter(count, filters, w);
}

void BroadPhase::find(const PoseColumns* links, const double* q, Filters filters, Workspace& w) const {
  begin(w);
  if (filters.overlaps && !permanent_pairs_.empty()) return take_overlapping(1, w);
  w.links.begin(links);
  const bool learns = filters.overlaps && filters.learning;
  // An overlap is a proof: the pair need not be found near before.
  if (learns) w.overlap = w.likely.first([&](std::size_t pair) { return overlap(pair, w) != 0; });
  if (w.overlap != LikelyOverlaps::kNone) {
    take_overlapping(1, w);
  } else {
    find_for_state(links, [&](std::size_t column) { return q[column]; }, 0, w);
    if (learns) w.likely.put_first(w.candidates);
    filter(1, filters, w);
  }
  if (learns) w.likely.learn(w.overlap);
}

// Sorts the candidates into `near`, less those that balls and boxes decide.
void BroadPhase::filter(int count, Filters filters, Workspace& w) const {
  if (filters.overlaps) {
    find_overlaps(count, 0, w);
    drop_overlapping(w);
  } else if (w.boxed) {
    for (Candidate& candidate : w.candidates) drop_apart(candidate, candidate.states, w);
  }
  if (w.boxed) {
    for (Candidate& candidate : w.candidates) drop_apart_at_edges(candidate, w);
  }
  w.undecided = permanent_pairs_.empty() ? 0 : ((1U << count) - 1) & ~w.overlapping;
  for (unsigned states = w.undecided; states != 0; states &= states - 1) {
    w.near[static_cast<std::size_t>(__builtin_ctz(states))] = permanent_pairs_;
  }
  w.near_pairs = static_cast<long>(permanent_pairs_.size()) * __builtin_popcount(w.undecided);
  const auto take = [&](const Candidate& candidate, unsigned states) {
    w.undecided |= states;
    w.near_pairs += __builtin_popcount(states);
    for (; states != 0; states &= states - 1) {
      w.near[static_cast<std::size_t>(__builtin_ctz(states))].push_back(candidate.pair);
    }
  };
  for (const Candidate& candidate : w.candidates) take(candidate, candidate.states);
  for (const Candidate& candidate : w.unboxed) {
    take(candidate, candidate.states & ~w.overlapping);
    w.skipped += __builtin_popcount(candidate.states & w.overlapping);
  }
}

// One pair decides every state.
void BroadPhase::take_overlapping(int count, Workspace& w) const {
  w.overlapping = (1U << count) - 1;
  w.skipped = count * (static_cast<long>(pairs_.size()) - 1);
  w.near_pairs = 0;
}

void BroadPhase::take_all(int count, Workspace& w) const {
  begin(w);
  for (std::size_t state = 0; state < static_cast<std::size_t>(count); ++state) {
    w.near[state].resize(pairs_.size());
    for (std::size_t k = 0; k < pairs_.size(); ++k) w.near[state][k] = static_cast<std::int32_t>(k);
  }
  w.near_pairs = count * static_cast<long>(pairs_.size());
  w.undecided = pairs_.empty() ? 0 : (1U << count) - 1;
}

// For the states that no overlap has decided yet.
void BroadPhase::find_for_block(BlockConfigurations q, int count, Filters filters, Workspace& w) const {
  const unsigned all = (1U << count) - 1;
  pose(movers_, w.fixed.movers, w.balls, w);
  if (obstacles_ <= kFewObstacles) {
    find_in_groups(count, filters, w);
  } else {
    for (const std::int32_t mover : movers_with_obstacles_) find_in_tree(mover, all & ~w.overlapping, w);
  }
  const unsigned open = all & ~w.overlapping;
  if (open == 0) return;
  pose(slices_, w.fixed.slices, w.slices, w);
  find_among_movers(q, open, w);
  const auto posed = [&](std::size_t mover) -> const Balls& { return w.balls[mover]; };
  const auto take = [&](std::int32_t pair, unsigned near) { w.unboxed.push_back({pair, near}); };
  plane_filter_.find(posed, open, take);
  height_filter_.find(posed, open, take);
}

// Where any collision decides, overlaps are looked for after each group, as those of one mostly decide all states: that
// of the last overlap goes first.
void BroadPhase::find_in_groups(int count, Filters filters, Workspace& w) const {
  const unsigned all = (1U << count) - 1;
  const auto choose = [&] { return mover_groups(movers_, world_boxes_, pair_of_, *sampled_); };
  const std::vector<MoverGroup>& groups = mover_groups_.get(choose);
  const std::size_t likeliest = w.likeliest_group;
  std::size_t unseen = pairs_.size();
  for (std::size_t k = 0; k < groups.size() && w.overlapping != all; ++k) {
    const std::size_t g = k == 0 ? likeliest : k <= likeliest ? k - 1 : k;
    find_listed(groups[g], all & ~w.overlapping, w);
    unseen -= groups[g].pairs;
    if (filters.overlaps && find_overlaps(count, unseen, w)) w.likeliest_group = g;
  }
}

const PoseColumns* BroadPhase::links_in_state(const Lanes* links, std::size_t state, Workspace& w) const {
  const Lanes* const group = links + pose_index(links_, state / kLanes, 0);
  for (const BoundingBall& mover : movers_) {
    const Lanes* const from = group + at(mover.link) * 12;
    double rows[12];
    for (std::size_t i = 0; i < 12; ++i) rows[i] = from[i][state % kLanes];
    w.state_links[at(mover.link)] = columns_of(rows);
  }
  return w.state_links.data();
}

template <class Value>
void BroadPhase::find_for_state(const PoseColumns* links, Value value, std::size_t state, Workspace& w) const {
  const unsigned bit = 1U << state;
  const auto take = [&](std::int32_t pair) { w.candidates.push_back({pair, bit}); };
  single_state_filter_.pose(links, w.single_state_filter);
  single_state_filter_.find(w.single_state_filter, take);
  for (const MovingPairsInCells& some : in_cells_) {
    for (unsigned may_meet = some.cells->of_state(value); may_meet != 0; may_meet &= may_meet - 1) {
      const MovingPair& pair = some.pairs[static_cast<std::size_t>(__builtin_ctz(may_meet))];
      if (pair.pair >= 0) take(pair.pair);
    }
  }
  const auto posed = [&](std::size_t mover) {
    const SingleStateFilter::Ball ball = SingleStateFilter::ball(mover, w.single_state_filter);
    return Balls{StateFloats{} + ball.x, StateFloats{} + ball.y, StateFloats{} + ball.z, StateFloats{} + ball.radius};
  };
  plane_filter_.find(posed, 1, [&](auto pair, auto) { w.unboxed.push_back({pair, bit}); });
  height_filter_.find(w.single_state_filter, [&](auto pair) { w.unboxed.push_back({pair, bit}); });
  for (std::size_t k = 0; obstacles_ > kFewObstacles && k < movers_with_obstacles_.size(); ++k) {
    const std::size_t mover = at(movers_with_obstacles_[k]);
    const SingleStateFilter::Ball ball = SingleStateFilter::ball(mover, w.single_state_filter);
    w.found.clear();
    tree_.collect({ball.x, ball.y, ball.z, ball.limit}, w.found);
    for (const std::int32_t obstacle : w.found) {
      const std::int32_t pair = pair_with(mover, obstacle);
      if (pair >= 0) take(pair);
    }
  }
}

void BroadPhase::fix_radii(const PoseError* errors, FixedRadii& fixed) const {
  const auto radii_of = [&](const std::vector<BoundingBall>& balls) {
    std::vector<float> radii;
    for (const BoundingBall& ball : balls) radii.push_back(ball.radius_anywhere(errors[at(ball.link)]));
    return radii;
  };
  fixed.movers = radii_of(movers_), fixed.slices = radii_of(slices_);
  fixed.from_obstacles.clear();
  for (const float radius : fixed.movers) fixed.from_obstacles.push_back(far_beyond(radius));
  fixed.of_pairs.assign(pairs_.size(), 0);
  const auto take = [&](const MovingPair& pair) {
    if (pair.pair >= 0) fixed.of_pairs[at(pair.pair)] = far_beyond(fixed.movers[at(pair.a)] + fixed.movers[at(pair.b)]);
  };
  for (const MovingPair& pair : moving_pairs_) take(pair);
  for (const MovingPairsInCells& some : in_cells_) std::for_each(some.pairs.begin(), some.pairs.end(), take);
}

void BroadPhase::pose(const std::vector<BoundingBall>& balls, const std::vector<float>& fixed_radii,
                      std::vector<Balls>& posed, Workspace& w) {
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const BoundingBall& ball = balls[i];
    const FloatPose& link = w.links.of(at(ball.link));
    const PoseError error = w.links.error(at(ball.link));
    const auto [x, y, z] = ball.centre;
    Balls& out = posed[i];
    out.x = link.turned(0, x, y, z) + link.m[3];
    out.y = link.turned(1, x, y, z) + link.m[7];
    out.z = link.turned(2, x, y, z) + link.m[11];
    out.radius = w.are_fixed ? filled<StateFloats>(fixed_radii[i]) : ball.radius_at(out.x, out.y, out.z, error);
  }
}

inline unsigned BroadPhase::near(const Balls& a, const Balls& b, StateFloats limit) {
  const StateFloats x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return ~bits_above(dot_of(x, y, z, x, y, z), limit);
}

// The states in which a slice of a mover is near another ball; all states of movers that are not sliced.
inline unsigned BroadPhase::near_slices(std::size_t mover, const Balls& other, const Workspace& w) const {
  const std::size_t first = first_slice_[mover], past = first_slice_[mover + 1];
  if (first == past) return ~0U;
  unsigned out = 0;
  for (std::size_t k = first; k < past; ++k) out |= near(w.slices[k], other);
  return out;
}

inline void BroadPhase::take_near(const MovingPair& pair, unsigned states, Workspace& w) const {
  const Balls &a = w.balls[at(pair.a)], &b = w.balls[at(pair.b)];
  const StateFloats limit =
      w.are_fixed ? filled<StateFloats>(w.fixed.of_pairs[at(pair.pair)]) : far_beyond(a.radius + b.radius);
  unsigned found = near(a, b, limit) & states;
  if (found == 0) return;
  found &= near_slices(at(pair.a), b, w) & near_slices(at(pair.b), a, w);
  if (found != 0) w.candidates.push_back({pair.pair, found});
}

void BroadPhase::find_among_movers(BlockConfigurations q, unsigned states, Workspace& w) const {
  for (const MovingPair& pair : moving_pairs_) take_near(pair, states, w);
  for (const MovingPairsInCells& some : in_cells_) {
    const PairsByState pairs = q.are_known() ? PairsByState(*some.cells, q) : PairsByState();
    for (unsigned any = pairs.in_any(); any != 0; any &= any - 1) {
      const auto k = static_cast<std::size_t>(__builtin_ctz(any));
      if (some.pairs[k].pair >= 0) take_near(some.pairs[k], states & pairs.states_of(k), w);
    }
  }
}

// The box around the group's movers in each state. The balls' radii have room for the rounding of one more sum.
BroadPhase::BoxInStates BroadPhase::around(const MoverGroup& group, const std::vector<Balls>& balls) const {
  const StateFloats infinity = StateFloats{} + __builtin_inff();
  BoxInStates out{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  StateFloats total{};
  for (std::size_t m = group.first; m < group.last; ++m) {
    const std::array<StateFloats, 3> centre{balls[m].x, balls[m].y, balls[m].z};
    for (std::size_t i = 0; i < 3; ++i) {
      out.low[i] = smaller(out.low[i], centre[i] - balls[m].radius);
      out.high[i] = larger(out.high[i], centre[i] + balls[m].radius);
    }
    total += balls[m].radius;
  }
  // A ball whose centre is infinite or NaN has such a radius, too, and may be anywhere.
  const StateMask known = total < infinity;
  for (std::size_t i = 0; i < 3; ++i) {
    out.low[i] = known ? out.low[i] : -infinity;
    out.high[i] = known ? out.high[i] : infinity;
  }
  return out;
}

unsigned BroadPhase::BoxInStates::met(const FloatBox& box) const {
  BitsOfAny<StateFloats> apart;
  for (std::size_t i = 0; i < 3; ++i) {
    apart.add_above(low[i], filled<StateFloats>(box.high[i]));
    apart.add_above(filled<StateFloats>(box.low[i]), high[i]);
  }
  return ~apart.bits();
}

BroadPhase::BoxInFloats BroadPhase::BoxInStates::around_all() const {
  BoxInFloats out;
  for (std::size_t i = 0; i < 3; ++i)
    out.low[i] = smallest_everywhere(low[i]), out.high[i] = -smallest_everywhere(-high[i]);
  return out;
}

unsigned BroadPhase::BoxInFloats::met(const BoxLanes<StateFloats>& boxes) const {
  BitsOfAny<StateFloats> apart;
  for (std::size_t i = 0; i < 3; ++i) {
    apart.add_above(low[i], boxes.high[i]);
    apart.add_above(boxes.low[i], high[i]);
  }
  return ~apart.bits() & boxes.present;
}

// Along motions most obstacles are far from a group in all states of a block.
void BroadPhase::find_listed(const MoverGroup& group, unsigned states, Workspace& w) const {
  const BoxInStates own = around(group, w.balls);
  const BoxInFloats in_all = own.around_all();
  for (std::size_t k = 0; k < group.boxes.size(); ++k) {
    for (unsigned met = in_all.met(group.boxes[k]); met != 0; met &= met - 1) {
      const std::size_t place = k * kBlockStates + static_cast<std::size_t>(__builtin_ctz(met));
      find_near_obstacle(group, own, group.obstacles[place], states, w);
    }
  }
}

inline void BroadPhase::find_near_obstacle(const MoverGroup& group, const BoxInStates& around, std::int32_t obstacle,
                                           unsigned states, Workspace& w) const {
  const FloatBox& box = float_boxes_[at(obstacle)];
  if ((around.met(box) & states) == 0) return;
  for (std::size_t m = group.first; m < group.last; ++m) {
    const std::int32_t pair = pair_with(m, obstacle);
    if (pair < 0) continue;
    const Balls& ball = w.balls[m];
    const StateFloats x = beyond(ball.x, box.low[0], box.high[0]), y = beyond(ball.y, box.low[1], box.high[1]);
    const StateFloats z = beyond(ball.z, box.low[2], box.high[2]);
    const StateFloats limit = w.are_fixed ? filled<StateFloats>(w.fixed.from_obstacles[m]) : far_beyond(ball.radius);
    const unsigned near = ~bits_above(dot_of(x, y, z, x, y, z), limit) & states;
    if (near != 0) w.candidates.push_back({pair, near});
  }
}

void BroadPhase::find_in_tree(std::int32_t mover, unsigned states, Workspace& w) const {
  const Balls& balls = w.balls[at(mover)];
  w.reached.clear();
  for (; states != 0; states &= states - 1) {
    const auto state = static_cast<std::size_t>(__builtin_ctz(states));
    w.found.clear();
    tree_.collect({balls.x[state], balls.y[state], balls.z[state], far_beyond(balls.radius[state])}, w.found);
    for (const std::int32_t obstacle : w.found) {
      if (w.states[at(obstacle)] == 0) w.reached.push_back(obstacle);
      w.states[at(obstacle)] |= 1U << state;
    }
  }
  const std::int32_t* pair_of = pair_of_.data() + at(mover) * obstacles_;
  for (const std::int32_t obstacle : w.reached) {
    if (pair_of[obstacle] >= 0) w.candidates.push_back({pair_of[obstacle], w.states[at(obstacle)]});
    w.states[at(obstacle)] = 0;
  }
}

void BroadPhase::drop(Candidate& candidate, unsigned apart, Workspace& w) {
  w.boxes_apart += __builtin_popcount(apart);
  candidate.states &= ~apart;
}

// Drops those of some states in which a face of the candidate's boxes separates them; returns the others.
unsigned BroadPhase::drop_apart(Candidate& candidate, unsigned states, Workspace& w) const {
  if (states == 0) return 0;
  const auto& pair = pairs_[at(candidate.pair)];
  const unsigned apart = states & boxes_.apart(w.links, at(pair[0]), at(pair[1]), w.boxes);
  drop(candidate, apart, w);
  return states & ~apart;
}

// Drops the states in which a plane along an edge separates the candidate's boxes. Such planes cost more than those of
// faces and are asked last, for what neither these nor overlaps have decided.
void BroadPhase::drop_apart_at_edges(Candidate& candidate, Workspace& w) const {
  if (candidate.states == 0) return;
  const auto& pair = pairs_[at(candidate.pair)];
  drop(candidate, candidate.states & boxes_.apart_at_edges(w.links, at(pair[0]), at(pair[1]), w.boxes), w);
}

// Bit k: whether a pair surely shares a point in state k.
unsigned BroadPhase::overlap(std::size_t pair, Workspace& w) const {
  if (!w.links.are_of_one_state()) return overlaps_.overlap(w.links, pair, boxes_, w.boxes, w.overlaps);
  return overlaps_.overlap_in_state(w.links, pair, boxes_, w.boxes, w.overlaps) ? 1U : 0U;
}

void BroadPhase::take_overlap(std::size_t pair, unsigned states, int count, Workspace& w) {
  if (states == 0) return;
  w.overlapping |= states;
  w.overlap = pair;
  if ((states >> (count - 1) & 1U) != 0) w.overlap_at_end = pair;
}

// Finds states that surely collide, by the candidates that it has not tested yet; whether there are more of them now.
// Boxes go first, since they decide more. `unseen`: pairs of which nobody has asked yet whether they are candidates.
bool BroadPhase::find_overlaps(int count, std::size_t unseen, Workspace& w) const {
  const unsigned before = w.overlapping;
  for (; w.tested < w.candidates.size(); ++w.tested) {
    Candidate& candidate = w.candidates[w.tested];
    unsigned open = candidate.states & ~w.overlapping;
    if (w.boxed) open = drop_apart(candidate, open, w);
    if (open != 0) take_overlap(at(candidate.pair), open & overlap(at(candidate.pair), w), count, w);
  }
  const unsigned found = w.overlapping & ~before;
  // The pairs that overlap are themselves among those that `drop_overlapping` counts.
  w.skipped += __builtin_popcount(found) * (static_cast<long>(unseen) - 1);
  return found != 0;
}

// Drops the states that surely collide.
void BroadPhase::drop_overlapping(Workspace& w) {
  if (w.overlapping == 0) return;
  for (Candidate& candidate : w.candidates) {
    w.skipped += __builtin_popcount(candidate.states & w.overlapping);
    candidate.states &= ~w.overlapping;
  }
}

}  // namespace plannercheck
