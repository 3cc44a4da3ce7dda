#include "broad_phase/broad_phase.hpp"

#include <limits>
#include <utility>

namespace plannercheck {
namespace {

// Of posing an obstacle's vertices in doubles: three products and sums.
constexpr double kVertexError = 8 * 0x1p-53;

// From this many states on, lanes over states beat lanes over obstacles and pairs' boxes one by one (measured).
constexpr int kFewStates = 3;
// No box is looked at before these filters' own tests.
bool is_unboxed(const GeometryObject& object) { return object.body->half_space || HeightFilter::is_for(object); }

// The box around a static body, with room for the rounding of its posed vertices.
WorldBox world_box(const GeometryObject& object) {
  const Polytope& body = *object.body;
  const Pose& pose = object.placement;
  const double infinity = std::numeric_limits<double>::infinity();
  WorldBox box{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (const Vec3& v : body.inner.points) {
    const Vec3 p = pose.apply(v);
    box.low = {smaller(box.low.x, p.x), smaller(box.low.y, p.y), smaller(box.low.z, p.z)};
    box.high = {larger(box.high.x, p.x), larger(box.high.y, p.y), larger(box.high.z, p.z)};
  }
  const double room = body.inflation_radius + kVertexError * (2 * body.origin_radius + norm_1(pose.translation()));
  const Vec3 margin{room, room, room};
  return {box.low - margin, box.high + margin};
}

}  // namespace

BroadPhase::BroadPhase(const std::vector<GeometryObject>& bodies, const std::vector<std::array<std::int32_t, 2>>& pairs,
                       const std::vector<bool>& permanent, std::size_t links,
                       std::shared_ptr<const SampledPoses> sampled)
    : links_(links), pairs_(pairs), obstacles_(0), sampled_(std::move(sampled)), tree_({}) {
  // The index of a body among the movers or among the obstacles, in the order of the bodies.
  std::vector<std::int32_t> place(bodies.size(), -1);
  std::vector<bool> used(bodies.size(), false);
  for (const auto& pair : pairs) {
    const bool moves = bodies[at(pair[0])].link >= 0 || bodies[at(pair[1])].link >= 0;
    for (const std::int32_t b : pair) used[at(b)] = used[at(b)] || (moves && !is_unboxed(bodies[at(b)]));
  }
  std::vector<WorldBox> boxes;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!used[b]) continue;
    const GeometryObject& object = bodies[b];
    if (object.link < 0) {
      place[b] = static_cast<std::int32_t>(boxes.size());
      boxes.push_back(world_box(object));
      continue;
    }
    place[b] = static_cast<std::int32_t>(movers_.size());
    movers_.push_back(bounding_ball(object));
  }
  obstacles_ = boxes.size();
  tree_ = ObstacleTree(boxes);
  pair_of_.assign(movers_.size() * obstacles_, -1);
  std::vector<bool> has_obstacle(movers_.size(), false);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto pair = static_cast<std::int32_t>(k);
    const bool first = bodies[at(pairs[k][0])].link >= 0, second = bodies[at(pairs[k][1])].link >= 0;
    const std::int32_t a = place[at(pairs[k][0])], b = place[at(pairs[k][1])];
    const std::int32_t still = pairs[k][first ? 1 : 0];
    if (first != second && bodies[at(still)].body->half_space) {
      plane_filter_.add(pair, at(first ? a : b), bodies[at(still)]);
    } else if (first != second && HeightFilter::is_for(bodies[at(still)])) {
      const std::size_t mover = at(first ? a : b);
      height_filter_.add(pair, mover, movers_[mover], still, bodies[at(still)]);
    } else if (first && second) {
      moving_pairs_.push_back({a, b, pair});
    } else if (!first && !second) {
      if (permanent[k]) permanent_pairs_.push_back(pair);
    } else {
      const std::int32_t mover = first ? a : b, obstacle = first ? b : a;
      pair_of_[at(mover) * obstacles_ + at(obstacle)] = pair;
      has_obstacle[at(mover)] = true;
    }
  }
  for (std::size_t m = 0; m < movers_.size(); ++m) {
    if (has_obstacle[m]) movers_with_obstacles_.push_back(static_cast<std::int32_t>(m));
  }
  std::vector<SingleStateFilter::Partner> with_movers, with_boxes;
  for (const MovingPair& pair : moving_pairs_) with_movers.push_back({at(pair.a), at(pair.b), pair.pair});
  if (obstacles_ <= kFewObstacles) {
    for (const WorldBox& box : boxes) spread_.push_back(spread(box));
    world_boxes_ = boxes;
    for (const std::int32_t mover : movers_with_obstacles_) {
      for (std::size_t o = 0; o < obstacles_; ++o) {
        const std::int32_t pair = pair_with(at(mover), static_cast<std::int32_t>(o));
        if (pair >= 0) with_boxes.push_back({at(mover), o, pair});
      }
    }
  } else {
    boxes.clear();
  }
  single_state_filter_ = SingleStateFilter(movers_, boxes, with_movers, with_boxes);
  std::vector<BodyBox> body_boxes;
  for (const GeometryObject& object : bodies) body_boxes.push_back(body_box(object));
  boxes_ = BlockBoxes(std::move(body_boxes));
  overlaps_ = BlockOverlaps(bodies, pairs);
}

BroadPhase::FloatBox BroadPhase::spread(const WorldBox& box) {
  FloatBox out;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    out.low[i] = StateFloats{} + rounded_down(box.low[axis]), out.high[i] = StateFloats{} + rounded_up(box.high[axis]);
  }
  return out;
}

BroadPhase::Workspace BroadPhase::new_workspace() const {
  Workspace w;
  w.links = RoundedLinks(links_);
  w.state_links.resize(links_);
  w.balls.resize(movers_.size());
  w.single_state_filter = single_state_filter_.new_workspace();
  w.boxes = boxes_.new_workspace();
  w.overlaps = overlaps_.new_workspace();
  w.candidates.reserve(pairs_.size());
  w.unboxed.reserve(plane_filter_.size() + height_filter_.size());
  w.found.reserve(obstacles_);
  w.likely = LikelyOverlaps(pairs_.size());
  w.reached.reserve(obstacles_);
  w.states.resize(obstacles_);
  for (auto& near : w.near) near.reserve(pairs_.size());
  return w;
}

void BroadPhase::begin(Workspace& w) {
  w.candidates.clear(), w.unboxed.clear();
  w.boxed = false;
  w.boxes_apart = w.skipped = 0;
  w.overlapping = 0;
  w.overlap = LikelyOverlaps::kNone;
  w.boxes.begin(), w.overlaps.begin();
}

void BroadPhase::find(const Lanes* links, int count, Filters filters, Workspace& w) const {
  begin(w);
  if (filters.overlaps && !permanent_pairs_.empty()) return take_overlapping(count, w);
  w.links.begin(links);
  if (count < kFewStates) {
    for (std::size_t state = 0; state < static_cast<std::size_t>(count); ++state)
      find_for_state(links_in_state(links, state, w), state, w);
  } else {
    find_for_block(count, w);
  }
  filter(count, filters, w);
}

// Sorts the candidates into `near`, less those that balls and boxes decide.
void BroadPhase::filter(int count, Filters filters, Workspace& w) const {
  w.boxed = filters.boxes && count >= kFewStates;
  if (filters.overlaps) {
    find_overlaps(w);
  } else if (w.boxed) {
    for (Candidate& candidate : w.candidates) drop_apart(candidate, candidate.states, w);
  }
  for (std::size_t state = 0; state < static_cast<std::size_t>(count); ++state) {
    w.near[state].clear();
    if ((w.overlapping >> state & 1U) != 0) continue;
    w.near[state].assign(permanent_pairs_.begin(), permanent_pairs_.end());
  }
  const auto take = [&](const Candidate& candidate, unsigned states) {
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
  for (auto& near : w.near) near.clear();
}

void BroadPhase::take_all(int count, Workspace& w) const {
  begin(w);
  for (std::size_t state = 0; state < static_cast<std::size_t>(count); ++state) {
    w.near[state].resize(pairs_.size());
    for (std::size_t k = 0; k < pairs_.size(); ++k) w.near[state][k] = static_cast<std::int32_t>(k);
  }
}

void BroadPhase::find_for_block(int count, Workspace& w) const {
  pose_balls(w);
  find_among_movers(count, w);
  const auto posed = [&](std::size_t mover) -> const Balls& { return w.balls[mover]; };
  const auto take = [&](std::int32_t pair, unsigned near) { w.unboxed.push_back({pair, near}); };
  plane_filter_.find(posed, (1U << count) - 1, take);
  height_filter_.find(posed, (1U << count) - 1, take);
  if (obstacles_ <= kFewObstacles) {
    const auto groups = [&] { return mover_groups(movers_, world_boxes_, pair_of_, *sampled_); };
    for (const MoverGroup& group : mover_groups_.get(groups)) find_listed(group, count, w);
  } else {
    for (const std::int32_t mover : movers_with_obstacles_) find_in_tree(mover, count, w);
  }
}

void BroadPhase::pose_balls(Workspace& w) const {
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const BoundingBall& mover = movers_[i];
    const FloatPose& link = w.links.of(at(mover.link));
    const auto [x, y, z] = mover.centre;
    Balls& balls = w.balls[i];
    balls.x = link.turned(0, x, y, z) + link.m[3];
    balls.y = link.turned(1, x, y, z) + link.m[7];
    balls.z = link.turned(2, x, y, z) + link.m[11];
    balls.radius = mover.radius_at(balls.x, balls.y, balls.z);
  }
}

void BroadPhase::find_among_movers(int count, Workspace& w) const {
  const unsigned states = (1U << count) - 1;
  for (const MovingPair& pair : moving_pairs_) {
    const Balls &a = w.balls[at(pair.a)], &b = w.balls[at(pair.b)];
    const StateFloats x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
    const unsigned near = ~bits_above((x * x + y * y) + z * z, far_beyond(a.radius + b.radius)) & states;
    if (near != 0) w.candidates.push_back({pair.pair, near});
  }
}

// The box around the group's movers in each state. The balls' radii have room for the rounding of one more sum.
BroadPhase::FloatBox BroadPhase::around(const MoverGroup& group, const std::vector<Balls>& balls) const {
  const StateFloats infinity = StateFloats{} + __builtin_inff();
  FloatBox out{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
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

void BroadPhase::find_listed(const MoverGroup& group, int count, Workspace& w) const {
  const unsigned states = (1U << count) - 1;
  const FloatBox own = around(group, w.balls);
  for (const std::int32_t obstacle : group.obstacles) {
    const FloatBox& box = spread_[at(obstacle)];
    const auto apart = [&](std::size_t i) {
      return bits_above(own.low[i], box.high[i]) | bits_above(box.low[i], own.high[i]);
    };
    if ((~(apart(0) | apart(1) | apart(2)) & states) == 0) continue;
    for (std::size_t m = group.first; m < group.last; ++m) {
      const std::int32_t pair = pair_with(m, obstacle);
      if (pair < 0) continue;
      const Balls& ball = w.balls[m];
      const StateFloats x = beyond(ball.x, box.low[0], box.high[0]), y = beyond(ball.y, box.low[1], box.high[1]);
      const StateFloats z = beyond(ball.z, box.low[2], box.high[2]);
      const unsigned near = ~bits_above((x * x + y * y) + z * z, far_beyond(ball.radius)) & states;
      if (near != 0) w.candidates.push_back({pair, near});
    }
  }
}

void BroadPhase::find_in_tree(std::int32_t mover, int count, Workspace& w) const {
  const Balls& balls = w.balls[at(mover)];
  w.reached.clear();
  for (std::size_t state = 0; state < static_cast<std::size_t>(count); ++state) {
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

// Drops those of some states in which the candidate's boxes are apart; returns the others.
unsigned BroadPhase::drop_apart(Candidate& candidate, unsigned states, Workspace& w) const {
  if (states == 0) return 0;
  const auto& pair = pairs_[at(candidate.pair)];
  const unsigned apart = states & boxes_.apart(w.links, at(pair[0]), at(pair[1]), w.boxes);
  w.boxes_apart += __builtin_popcount(apart);
  candidate.states &= ~apart;
  return states & ~apart;
}

// Bit k: whether a pair surely shares a point in state k.
unsigned BroadPhase::overlap(std::size_t pair, Workspace& w) const {
  if (!w.links.are_of_one_state()) return overlaps_.overlap(w.links, pair, boxes_, w.boxes, w.overlaps);
  return overlaps_.overlap_in_state(w.links, pair, boxes_, w.boxes, w.overlaps) ? 1U : 0U;
}

// Finds states that surely collide; these are dropped at once. Boxes go first, since they decide more.
void BroadPhase::find_overlaps(Workspace& w) const {
  for (Candidate& candidate : w.candidates) {
    unsigned open = candidate.states & ~w.overlapping;
    if (w.boxed) open = drop_apart(candidate, open, w);
    if (open != 0) open &= overlap(at(candidate.pair), w);
    if (open == 0) continue;
    w.overlapping |= open;
    w.overlap = at(candidate.pair);
  }
  if (w.overlapping == 0) return;
  for (Candidate& candidate : w.candidates) {
    w.skipped += __builtin_popcount(candidate.states & w.overlapping);
    candidate.states &= ~w.overlapping;
  }
  w.skipped += (static_cast<long>(permanent_pairs_.size()) - 1) * __builtin_popcount(w.overlapping);
}

}  // namespace plannercheck
