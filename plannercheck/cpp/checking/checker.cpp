#include "checking/checker.hpp"

#include <algorithm>
#include <utility>

#include "broad_phase/part_clearances.hpp"
#include "checking/checker_workspace.hpp"
#include "math/interruption.hpp"
#include "narrow_phase/pair_kernels.hpp"

namespace plannercheck {
namespace {

// Pairs of static bodies that share a point. The other pairs of static bodies are apart, and no state tests them.
std::vector<bool> permanent_collisions(const std::vector<GeometryObject>& bodies,
                                       const std::vector<std::array<std::int32_t, 2>>& pairs,
                                       const PairOptions& options) {
  std::vector<bool> out(pairs.size(), false);
  PairCounters counters;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const GeometryObject &body_a = bodies[at(pairs[k][0])], &body_b = bodies[at(pairs[k][1])];
    if (body_a.link >= 0 || body_b.link >= 0) continue;
    const PosedPolytope a{body_a.body.get(), body_a.placement}, b{body_b.body.get(), body_b.placement};
    out[k] = share_a_point(a, b, options, counters);
  }
  return out;
}

// How far bodies on links come from the world's origin in sampled states, m.
double largest_reach(const std::vector<GeometryObject>& bodies, std::size_t links, const SampledPoses* sampled) {
  if (sampled == nullptr || sampled->states == 0) return kNoLimit;
  double reach = 0;
  for (const GeometryObject& object : bodies) {
    if (object.link < 0) continue;
    const double size = norm_1(object.placement.translation()) + object.body->origin_radius;
    for (std::size_t s = 0; s < sampled->states; ++s) {
      const double* const pose = &sampled->poses[(s * links + at(object.link)) * 16];
      reach = larger(reach, norm_max({pose[3], pose[7], pose[11]}) + size);
    }
  }
  return reach;
}

class HullsOfPair final : public HullTest {
 public:
  HullsOfPair(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairFrame& frame, bool likely,
              const PairOptions& options, PairMemory& memory, CheckerCounters& counters)
      : body_a_(body_a),
        body_b_(body_b),
        frame_(frame),
        likely_(likely),
        options_(options),
        memory_(memory),
        counters_(counters) {}

  bool share() override {
    was_asked_ = true;
    const PairVerdict verdict = test_pair(body_a_, body_b_, frame_, likely_, options_, &memory_, counters_.pair);
    ++counters_.stages[static_cast<std::size_t>(verdict.stage)];
    settled_ = verdict.settles;
    return verdict.shared;
  }
  bool settled() const override { return settled_; }

  bool was_asked() const { return was_asked_; }

 private:
  const PosedPolytope &body_a_, &body_b_;
  const PairFrame& frame_;
  bool likely_;
  const PairOptions& options_;
  PairMemory& memory_;
  CheckerCounters& counters_;
  bool was_asked_ = false, settled_ = true;
};

}  // namespace

CheckerCounters& operator+=(CheckerCounters& sum, const CheckerCounters& more) {
  sum.states += more.states, sum.pairs += more.pairs, sum.bounds += more.bounds;
  sum.boxes += more.boxes, sum.overlaps += more.overlaps, sum.skipped += more.skipped;
  sum.trees += more.trees;
  for (std::size_t i = 0; i < sum.stages.size(); ++i) sum.stages[i] += more.stages[i];
  sum.pair += more.pair;
  return sum;
}

CheckerCore::CheckerCore(std::vector<GeometryObject> bodies, std::vector<std::array<std::int32_t, 2>> pairs,
                         std::int32_t links, Tuning tuning, std::shared_ptr<const SampledPoses> sampled,
                         const std::vector<PairsInCells>& in_cells)
    : bodies_(std::move(bodies)), pairs_(std::move(pairs)), links_(links), needed_(at(links), 0), tuning_(tuning) {
  for (auto& pair : pairs_) {
    if (choose_b(*bodies_[at(pair[0])].body, *bodies_[at(pair[1])].body) == 0) std::swap(pair[0], pair[1]);
    kinds_.push_back(kind_of(*bodies_[at(pair[0])].body, *bodies_[at(pair[1])].body));
    for (const std::int32_t body : pair) {
      const std::int32_t link = bodies_[at(body)].link;
      if (link >= 0) needed_[at(link)] = 1;
    }
  }
  clearances_ = std::make_shared<const PartClearances>(bodies_, largest_reach(bodies_, at(links_), sampled.get()));
  broad_phase_ = std::make_shared<const BroadPhase>(bodies_, pairs_, permanent_collisions(bodies_, pairs_, tuning_),
                                                    std::move(sampled), in_cells);
}

std::shared_ptr<CheckerCore::Workspace> CheckerCore::new_workspace() const {
  auto w = std::make_shared<Workspace>();
  w->links = LinkPoses(at(links_));
  w->rounded = RoundedPoses(at(links_));
  w->single = SingleState(at(links_));
  w->broad_phase = broad_phase_->new_workspace();
  w->open = OpenStates(pairs_.size());
  w->memories.resize(pairs_.size());
  w->histories.resize(pairs_.size(), {{}, true, tuning_.cached_plane});
  w->clear.resize(pairs_.size());
  w->collisions.resize(pairs_.size(), RecentRate(64, 16, 8, 2));
  return w;
}

CheckerCounters CheckerCore::take_counters(Workspace& w) { return std::exchange(w.counters, {}); }

Pose CheckerCore::body_pose(std::size_t body, const double* links) const {
  const GeometryObject& object = bodies_[body];
  if (object.link < 0) return object.placement;
  std::array<double, 12> link;
  std::copy_n(links + at(object.link) * kPoseStride, 12, link.begin());
  return placed_on(link, object.placement);
}

Pose CheckerCore::posed(std::size_t body, std::size_t state, const Workspace& w) const {
  const GeometryObject& object = bodies_[body];
  if (object.link < 0) return object.placement;
  return placed_on(w.links.of(at(object.link), state), object.placement);
}

// Whether filters have looked at boxes.
bool CheckerCore::are_boxed(const Workspace& w) const { return tuning_.bounds && !w.links.are_of_one_state(); }

// `are_hulls`: whether both bodies are hulls; if not, at least one is a solid.
template <bool are_hulls>
bool CheckerCore::hulls_share(std::size_t pair, std::size_t state, Workspace& w) const {
  const std::size_t body_a = at(pairs_[pair][0]), body_b = at(pairs_[pair][1]);
  const PosedPolytope a{bodies_[body_a].body.get(), posed(body_a, state, w)};
  const PosedPolytope b{bodies_[body_b].body.get(), posed(body_b, state, w)};
  const PairFrame frame(a, b, tuning_.dents);
  if (tuning_.boxes && !are_boxed(w) && frame.boxes_apart()) {
    ++w.counters.boxes;
    return false;
  }
  const bool likely = tuning_.learning && !w.collisions[pair].is_at_most(0.5);
  HullsOfPair hulls(a, b, frame, likely, tuning_, w.memories[pair], w.counters);
  bool shared;
  if constexpr (are_hulls) {
    shared = hulls.share();
  } else {
    shared = solids_share_with(a, b, hulls, tuning_.trees_first, w.histories[pair], w.counters.pair);
    if (!hulls.was_asked()) ++w.counters.trees;
  }
  return shared;
}

const KindTable<CheckerCore::PairTest> CheckerCore::kPairTests{
    &CheckerCore::hulls_share<true>, &CheckerCore::hulls_share<false>, &CheckerCore::parts_share,
    &CheckerCore::half_space_shared};

// Most pairs are two hulls: they need no call through a pointer.
bool CheckerCore::collides(std::size_t pair, std::size_t state, Workspace& w) const {
  const Kind kind = kinds_[pair];
  const bool shared =
      kind == Kind::kHull ? hulls_share<true>(pair, state, w) : (this->*kPairTests[kind])(pair, state, w);
  w.collisions[pair].add(1, shared ? 1 : 0);
  return shared;
}

}  // namespace plannercheck
