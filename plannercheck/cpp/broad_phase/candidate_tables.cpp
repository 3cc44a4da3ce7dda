// What the search for candidates prepares, once a checker: which bodies move, around which obstacles there are boxes,
// and how each pair is found.
#include <limits>
#include <utility>

#include "broad_phase/candidate_search.hpp"

namespace plannercheck {
namespace {

// The rounding of an obstacle's vertices, posed in doubles: three products and sums.
constexpr double kVertexError = 8 * 0x1p-53;

// Half-spaces and height fields have filters of their own, in place of boxes.
bool is_unboxed(const GeometryObject& object) {
  return !object.body->traits().is_bounded || HeightFilter::is_for(object);
}

// The box around a static body, with room for the rounding of its posed vertices.
Box world_box(const GeometryObject& object) {
  const Polytope& body = *object.body;
  return box_around_hull(object).grown(
      body.inflation_radius + kVertexError * (2 * body.origin_radius + norm_1(object.placement.translation())));
}

}  // namespace

CandidateSearch::CandidateSearch(const std::vector<GeometryObject>& bodies,
                                 const std::vector<std::array<std::int32_t, 2>>& pairs,
                                 std::shared_ptr<const SampledPoses> sampled, const std::vector<PairsInCells>& in_cells)
    : pairs_(pairs.size()), sampled_(std::move(sampled)), tree_({}) {
  // The index of a body among the movers or among the obstacles, in the order of the bodies.
  std::vector<std::int32_t> place(bodies.size(), -1);
  std::vector<bool> used(bodies.size(), false);
  for (const auto& pair : pairs) {
    const bool moves = bodies[at(pair[0])].link >= 0 || bodies[at(pair[1])].link >= 0;
    for (const std::int32_t b : pair) used[at(b)] = used[at(b)] || (moves && !is_unboxed(bodies[at(b)]));
  }
  std::vector<Box> boxes;
  std::vector<const GeometryObject*> objects;  // the movers
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
    objects.push_back(&object);
  }
  obstacles_ = boxes.size();
  tree_ = ObstacleTree(boxes);
  pair_of_.assign(movers_.size() * obstacles_, -1);
  std::vector<bool> has_obstacle(movers_.size(), false), is_in_cells(pairs.size(), false);
  for (const PairsInCells& some : in_cells) {
    MovingPairsInCells& own = in_cells_.emplace_back();
    own.cells = some.cells;
    for (std::size_t bit = 0; bit < some.pairs.size(); ++bit) {
      const std::int32_t pair = some.pairs[bit];
      own.pairs[bit] = {0, 0, -1};
      if (pair < 0) continue;
      const auto [a, b] = pairs[at(pair)];
      if (bodies[at(a)].link < 0 || bodies[at(b)].link < 0) continue;  // one is an obstacle, and no mover
      own.pairs[bit] = {place[at(a)], place[at(b)], pair};
      is_in_cells[at(pair)] = true;
    }
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto pair = static_cast<std::int32_t>(k);
    const bool first = bodies[at(pairs[k][0])].link >= 0, second = bodies[at(pairs[k][1])].link >= 0;
    const std::int32_t a = place[at(pairs[k][0])], b = place[at(pairs[k][1])];
    const std::int32_t still = pairs[k][first ? 1 : 0];
    if (first != second && !bodies[at(still)].body->traits().is_bounded) {
      plane_filter_.add(pair, at(first ? a : b), bodies[at(still)]);
    } else if (first != second && HeightFilter::is_for(bodies[at(still)])) {
      const std::size_t mover = at(first ? a : b);
      height_filter_.add(pair, mover, movers_[mover], still, bodies[at(still)]);
    } else if (first && second) {
      if (!is_in_cells[k]) moving_pairs_.push_back({a, b, pair});
    } else if (first || second) {
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
    for (const Box& box : boxes) float_boxes_.push_back(rounded_outwards(box));
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
  std::vector<std::vector<BoundingBall>> slices;
  for (BodySlices& of_mover : body_slices(objects, movers_, moving_pairs_, *sampled_)) {
    first_slice_.push_back(slices_.size());
    if (of_mover.pay_in_blocks) slices_.insert(slices_.end(), of_mover.balls.begin(), of_mover.balls.end());
    slices.push_back(std::move(of_mover.balls));
  }
  first_slice_.push_back(slices_.size());
  single_state_filter_ = SingleStateFilter(movers_, slices, boxes, with_movers, with_boxes);
}

CandidateSearch::Workspace CandidateSearch::new_workspace() const {
  Workspace w;
  w.balls.resize(movers_.size()), w.around.resize(movers_.size()), w.slices.resize(slices_.size());
  w.single_state_filter = single_state_filter_.new_workspace();
  w.candidates.reserve(pairs_);
  w.unboxed.reserve(plane_filter_.rows().size() + height_filter_.rows().size());
  w.found.reserve(obstacles_);
  w.reached.reserve(obstacles_);
  w.states.resize(obstacles_);
  return w;
}

}  // namespace plannercheck
