// The broad phase of a single state: lanes run over bodies.
#include "broad_phase/broad_phase.hpp"

namespace plannercheck {

void BroadPhase::find(const PoseColumns* links, Filters filters, Workspace& w) const {
  begin(w);
  if (filters.overlaps && !permanent_pairs_.empty()) return take_overlapping(1, w);
  w.links.begin(links);
  const bool learns = filters.overlaps && filters.learning;
  // An overlap is a proof: the pair need not be found near before.
  if (learns) w.overlap = w.likely.first([&](std::size_t pair) { return overlap(pair, w) != 0; });
  if (w.overlap != LikelyOverlaps::kNone) {
    take_overlapping(1, w);
  } else {
    find_for_state(links, 0, w);
    if (learns) w.likely.put_first(w.candidates);
    filter(1, filters, w);
  }
  if (learns) w.likely.learn(w.overlap);
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

void BroadPhase::find_for_state(const PoseColumns* links, std::size_t state, Workspace& w) const {
  const unsigned bit = 1U << state;
  const auto take = [&](std::int32_t pair) { w.candidates.push_back({pair, bit}); };
  single_state_filter_.pose(links, w.single_state_filter);
  single_state_filter_.find(w.single_state_filter, take);
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

}  // namespace plannercheck
