#include "broad_phase/candidate_search.hpp"

#include <algorithm>

#include "broad_phase/pairs_by_state.hpp"

namespace plannercheck {

// ----- one state

std::size_t CandidateSearch::begin(const SingleState& state, Workspace& w) const {
  w.candidates.clear(), w.unboxed.clear();
  w.unseen = 0;
  single_state_filter_.pose(state.columns(), w.single_state_filter);
  return 1;
}

void CandidateSearch::find(std::size_t, const SingleState& state, unsigned, Workspace& w) const {
  const auto take = [&](std::int32_t pair) { w.candidates.push_back({pair, 1}); };
  single_state_filter_.find(w.single_state_filter, take);
  for (const MovingPairsInCells& some : in_cells_) {
    const auto number = [&](std::size_t column) { return state.number(column); };
    for (unsigned may_meet = some.cells->of_state(number); may_meet != 0; may_meet &= may_meet - 1) {
      const MovingPair& pair = some.pairs[static_cast<std::size_t>(__builtin_ctz(may_meet))];
      if (pair.pair >= 0) take(pair.pair);
    }
  }
  const auto ball = [&](std::size_t mover) { return SingleStateFilter::ball(mover, w.single_state_filter); };
  const auto in_all = [&](const SingleStateFilter::Ball& b) {
    return PosedBalls{StateFloats{} + b.x, StateFloats{} + b.y, StateFloats{} + b.z, StateFloats{} + b.radius};
  };
  for (const PlaneFilter::Row& row : plane_filter_.rows()) {
    if ((PlaneFilter::look(row, in_all(ball(row.ball))).apart & 1U) == 0) w.unboxed.push_back({row.pair, 1});
  }
  height_filter_.find(w.single_state_filter, [&](std::int32_t pair) { w.unboxed.push_back({pair, 1}); });
  for (std::size_t k = 0; obstacles_ > kFewObstacles && k < movers_with_obstacles_.size(); ++k) {
    const std::size_t mover = at(movers_with_obstacles_[k]);
    const SingleStateFilter::Ball own = ball(mover);
    w.found.clear();
    tree_.collect({own.x, own.y, own.z, own.limit}, w.found);
    for (const std::int32_t obstacle : w.found) {
      const std::int32_t pair = pair_with(mover, obstacle);
      if (pair >= 0) take(pair);
    }
  }
}

// ----- a block of states

std::size_t CandidateSearch::begin(const FloatBlock& block, Workspace& w) const {
  w.candidates.clear(), w.unboxed.clear();
  w.unseen = pairs_;
  w.are_fixed = block.always != 0;
  if (w.are_fixed && w.fixed.always != block.always) {
    fix_radii(block.errors, w.fixed);
    w.fixed.always = block.always;
  }
  pose(block, movers_, w.fixed.movers, w.are_fixed, w.balls);
  w.groups =
      &mover_groups_.get([&] { return mover_groups(movers_, world_boxes_, pair_of_, moving_pairs_, *sampled_); });
  return w.groups->groups.size() + 1;
}

void CandidateSearch::find(std::size_t step, const FloatBlock& block, unsigned states, Workspace& w) const {
  if (step < w.groups->groups.size()) return find_in_group(step, states, w);
  w.unseen = 0;
  if (obstacles_ > kFewObstacles) {
    for (const std::int32_t mover : movers_with_obstacles_) find_in_tree(mover, states, w);
  }
  pose(block, slices_, w.fixed.slices, w.are_fixed, w.slices);
  find_among_movers(block.q, states, w);
  const auto take = [&](std::int32_t pair, Masks masks) {
    if (const unsigned near = states & ~masks.apart; near != 0) w.unboxed.push_back({pair, near});
  };
  for (const PlaneFilter::Row& row : plane_filter_.rows()) take(row.pair, PlaneFilter::look(row, w.balls[row.ball]));
  for (const HeightFilter::Row& row : height_filter_.rows())
    take(row.pair, height_filter_.look(row, w.balls[row.ball]));
}

void CandidateSearch::fix_radii(const PoseError* errors, FixedRadii& fixed) const {
  const auto radii_of = [&](const std::vector<BoundingBall>& balls) {
    std::vector<float> radii;
    for (const BoundingBall& ball : balls) radii.push_back(ball.radius_anywhere(errors[at(ball.link)]));
    return radii;
  };
  fixed.movers = radii_of(movers_), fixed.slices = radii_of(slices_);
  fixed.from_obstacles.clear();
  for (const float radius : fixed.movers) fixed.from_obstacles.push_back(far_beyond(radius));
  fixed.of_pairs.assign(pairs_, 0);
  const auto take = [&](const MovingPair& pair) {
    if (pair.pair >= 0) fixed.of_pairs[at(pair.pair)] = far_beyond(fixed.movers[at(pair.a)] + fixed.movers[at(pair.b)]);
  };
  for (const MovingPair& pair : moving_pairs_) take(pair);
  for (const MovingPairsInCells& some : in_cells_) std::for_each(some.pairs.begin(), some.pairs.end(), take);
}

void CandidateSearch::pose(const FloatBlock& block, const std::vector<BoundingBall>& balls,
                           const std::vector<float>& fixed_radii, bool are_fixed, std::vector<PosedBalls>& posed) {
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const BoundingBall& ball = balls[i];
    const FloatPose& link = block.pose(at(ball.link));
    const auto [x, y, z] = ball.centre;
    PosedBalls& out = posed[i];
    out.x = link.turned(0, x, y, z) + link.m[3];
    out.y = link.turned(1, x, y, z) + link.m[7];
    out.z = link.turned(2, x, y, z) + link.m[11];
    out.radius = are_fixed ? filled<StateFloats>(fixed_radii[i])
                           : ball.radius_at(out.x, out.y, out.z, block.error(at(ball.link)));
  }
}

// The states in which a slice of a mover is near another ball; all states of movers that are not sliced.
inline unsigned CandidateSearch::near_slices(std::size_t mover, const PosedBalls& other, const Workspace& w) const {
  const std::size_t first = first_slice_[mover], past = first_slice_[mover + 1];
  if (first == past) return ~0U;
  unsigned out = 0;
  for (std::size_t k = first; k < past; ++k) out |= w.slices[k].near(other);
  return out;
}

inline void CandidateSearch::take_near(const MovingPair& pair, unsigned states, Workspace& w) const {
  const PosedBalls &a = w.balls[at(pair.a)], &b = w.balls[at(pair.b)];
  const StateFloats limit =
      w.are_fixed ? filled<StateFloats>(w.fixed.of_pairs[at(pair.pair)]) : far_beyond(a.radius + b.radius);
  unsigned found = a.near(b, limit) & states;
  if (found == 0) return;
  found &= near_slices(at(pair.a), b, w) & near_slices(at(pair.b), a, w);
  if (found != 0) w.candidates.push_back({pair.pair, found});
}

void CandidateSearch::find_among_movers(BlockConfigurations q, unsigned states, Workspace& w) const {
  for (const auto& [a, b, pairs] : w.groups->among_movers) {
    const unsigned met = a == b ? states : w.around[a].met(w.around[b]) & states;
    if (met == 0) continue;
    for (const MovingPair& pair : pairs) take_near(pair, met, w);
  }
  for (const MovingPairsInCells& some : in_cells_) {
    const PairsByState pairs = q.are_known() ? PairsByState(*some.cells, q) : PairsByState();
    for (unsigned any = pairs.in_any(); any != 0; any &= any - 1) {
      const auto k = static_cast<std::size_t>(__builtin_ctz(any));
      if (some.pairs[k].pair >= 0) take_near(some.pairs[k], states & pairs.states_of(k), w);
    }
  }
}

// First tests a box around all states: along motions most obstacles are far from a group in all states of a block.
void CandidateSearch::find_in_group(std::size_t index, unsigned states, Workspace& w) const {
  const MoverGroup& group = w.groups->groups[index];
  if (group.obstacles.empty() && !group.has_partners) return;
  const BoxInStates own = box_around(&w.balls[group.first], group.last - group.first);
  if (group.has_partners) w.around[index] = own;
  w.unseen -= group.pairs;
  const BoxInFloats in_all = own.around_all();
  for (std::size_t k = 0; k < group.boxes.size(); ++k) {
    for (unsigned met = in_all.met(group.boxes[k]); met != 0; met &= met - 1) {
      const std::size_t place = k * kBlockStates + static_cast<std::size_t>(__builtin_ctz(met));
      find_near_obstacle(group, own, group.obstacles[place], states, w);
    }
  }
}

inline void CandidateSearch::find_near_obstacle(const MoverGroup& group, const BoxInStates& around,
                                                std::int32_t obstacle, unsigned states, Workspace& w) const {
  const FloatBox& box = float_boxes_[at(obstacle)];
  if ((around.met(box) & states) == 0) return;
  for (std::size_t m = group.first; m < group.last; ++m) {
    const std::int32_t pair = pair_with(m, obstacle);
    if (pair < 0) continue;
    const PosedBalls& ball = w.balls[m];
    const StateFloats x = beyond(ball.x, box.low[0], box.high[0]), y = beyond(ball.y, box.low[1], box.high[1]);
    const StateFloats z = beyond(ball.z, box.low[2], box.high[2]);
    const StateFloats limit = w.are_fixed ? filled<StateFloats>(w.fixed.from_obstacles[m]) : far_beyond(ball.radius);
    const unsigned near = ~bits_above(dot_of(x, y, z, x, y, z), limit) & states;
    if (near != 0) w.candidates.push_back({pair, near});
  }
}

void CandidateSearch::find_in_tree(std::int32_t mover, unsigned states, Workspace& w) const {
  const PosedBalls& balls = w.balls[at(mover)];
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

}  // namespace plannercheck
