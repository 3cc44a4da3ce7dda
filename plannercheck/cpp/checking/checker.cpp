#include "checking/checker.hpp"

#include <algorithm>
#include <utility>

#include "broad_phase/part_clearances.hpp"
#include "checking/checker_workspace.hpp"
#include "math/interruption.hpp"
#include "narrow_phase/pair_kernels.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kPoseStride = 16;  // of posed links: row-major 4x4

// A test of a pair that seldom collides costs more than it saves where nothing but time depends on it. So one that
// collided in less than one of kSeldom tests lately is left out, all but each kTriedAgain-th time, which tells whether
// that still holds. Tests of about kLately ago count half (all measured).
constexpr std::uint32_t kSeldom = 8, kTriedAgain = 16, kLately = 64;

bool is_left_out(std::uint32_t& hits, std::uint32_t& tests, std::uint32_t& left_out) {
  while (tests > kLately) tests /= 2, hits /= 2;
  return kSeldom * (hits + 1) < tests && ++left_out % kTriedAgain != 0;
}

// Which pairs share a point although both bodies stand still. Other such pairs are apart: no state tests either.
std::vector<bool> permanent_collisions(const std::vector<GeometryObject>& bodies,
                                       const std::vector<std::array<std::int32_t, 2>>& pairs,
                                       const PairOptions& options) {
  std::vector<bool> out(pairs.size(), false);
  PairCounters counters;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const GeometryObject &guest = bodies[at(pairs[k][0])], &host = bodies[at(pairs[k][1])];
    if (guest.link >= 0 || host.link >= 0) continue;
    const PosedPolytope a{guest.body.get(), guest.placement}, b{host.body.get(), host.placement};
    out[k] = kernel_of(a, b).share(a, b, options, counters);
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

// Put together in registers: a wide load after narrower stores would wait for them.
PoseColumns columns_in_lane(const Lanes* pose, std::size_t lane) {
  PoseColumns out;
  for (std::size_t k = 0; k < 4; ++k) out.column[k] = Double4{pose[k][lane], pose[4 + k][lane], pose[8 + k][lane], 0};
  return out;
}

BroadPhase::Filters filters_of(const Tuning& tuning, Query query) {
  return {tuning.overlaps && query == Query::kAnyCollision, tuning.boxes, tuning.learning};
}

class HullsOfPair final : public HullTest {
 public:
  HullsOfPair(const PosedPolytope& guest, const PosedPolytope& host, const PairFrame& frame, bool likely,
              const PairOptions& options, PairMemory& memory, CheckerCounters& counters)
      : guest_(guest),
        host_(host),
        frame_(frame),
        likely_(likely),
        options_(options),
        memory_(memory),
        counters_(counters) {}

  bool share() override {
    was_asked_ = true;
    const PairVerdict verdict = test_pair(guest_, host_, frame_, likely_, options_, &memory_, counters_.pair);
    ++counters_.stages[static_cast<std::size_t>(verdict.stage)];
    settled_ = verdict.settles;
    return verdict.shared;
  }
  bool settled() const override { return settled_; }

  bool was_asked() const { return was_asked_; }

 private:
  const PosedPolytope &guest_, &host_;
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
    if (choose_host(*bodies_[at(pair[0])].body, *bodies_[at(pair[1])].body) == 0) std::swap(pair[0], pair[1]);
    kinds_.push_back(kind_of(*bodies_[at(pair[0])].body, *bodies_[at(pair[1])].body));
    for (const std::int32_t body : pair) {
      const std::int32_t link = bodies_[at(body)].link;
      if (link >= 0) needed_[at(link)] = 1;
    }
  }
  part_groups_ = part_groups(bodies_, pairs_);
  clearances_ = std::make_shared<const PartClearances>(bodies_, largest_reach(bodies_, at(links_), sampled.get()));
  broad_phase_ = std::make_shared<const BroadPhase>(bodies_, pairs_, permanent_collisions(bodies_, pairs_, tuning_),
                                                    at(links_), std::move(sampled), in_cells);
}

std::shared_ptr<CheckerCore::Workspace> CheckerCore::new_workspace() const {
  auto w = std::make_shared<Workspace>();
  w->links.resize(kBlockGroups * at(links_) * 12);
  w->broad_phase = broad_phase_->new_workspace();
  w->open = OpenStates(pairs_.size());
  w->memories.resize(pairs_.size());
  if (std::any_of(kinds_.begin(), kinds_.end(), [](Kind kind) { return kind != Kind::kHull; })) {
    w->histories.resize(pairs_.size(), {{}, true, tuning_.cached_plane});
    w->clear.resize(pairs_.size());
  }
  w->groups.resize(part_groups_.groups.size());
  w->hits.resize(pairs_.size());
  w->tests.resize(pairs_.size());
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
  if (w.state_links != nullptr) return placed_on(w.state_links[at(object.link)], object.placement);
  const Lanes* const link = &w.links[pose_index(at(links_), state / kLanes, at(object.link))];
  return placed_on(columns_in_lane(link, state % kLanes), object.placement);
}

std::array<double, 12> CheckerCore::link_pose(std::size_t link, std::size_t state, const Workspace& w) const {
  if (w.state_links != nullptr) return w.state_links[link].by_rows().m;
  const Lanes* lanes = &w.links[pose_index(at(links_), state / kLanes, link)];
  std::array<double, 12> pose;
  for (std::size_t i = 0; i < 12; ++i) pose[i] = lanes[i][state % kLanes];
  return pose;
}

// `are_hulls`: else one is a solid at least.
template <bool are_hulls>
bool CheckerCore::hulls_share(std::size_t pair, std::size_t state, Workspace& w) const {
  const std::size_t guest = at(pairs_[pair][0]), host = at(pairs_[pair][1]);
  const PosedPolytope a{bodies_[guest].body.get(), posed(guest, state, w)};
  const PosedPolytope b{bodies_[host].body.get(), posed(host, state, w)};
  const PairFrame frame(a, b, tuning_.dents);
  if (tuning_.boxes && !w.broad_phase.boxed && frame.boxes_apart()) {
    ++w.counters.boxes;
    return false;
  }
  const bool likely = tuning_.learning && 2 * w.hits[pair] > w.tests[pair]++;
  HullsOfPair hulls(a, b, frame, likely, tuning_, w.memories[pair], w.counters);
  bool shared;
  if constexpr (are_hulls) {
    shared = hulls.share();
  } else {
    shared = solids_share_with(a, b, hulls, tuning_.trees_first, w.histories[pair], w.counters.pair);
    if (!hulls.was_asked()) ++w.counters.trees;
  }
  w.hits[pair] += shared ? 1 : 0;
  return shared;
}

const KindTable<CheckerCore::PairTest> CheckerCore::kPairTests{
    &CheckerCore::hulls_share<true>, &CheckerCore::hulls_share<false>, &CheckerCore::parts_share,
    &CheckerCore::half_space_shared};

// Two hulls, as most pairs are, without a call through a pointer.
inline bool CheckerCore::collides(std::size_t pair, std::size_t state, Workspace& w) const {
  const Kind kind = kinds_[pair];
  return kind == Kind::kHull ? hulls_share<true>(pair, state, w) : (this->*kPairTests[kind])(pair, state, w);
}

// Most states are decided, so that this is inlined where they are judged, and no more than this.
inline bool CheckerCore::is_free(std::size_t state, Workspace& w) const {
  if ((w.broad_phase.undecided >> state & 1U) != 0) return no_pair_collides(state, w);
  return (w.broad_phase.overlapping >> state & 1U) == 0;
}

bool CheckerCore::no_pair_collides(std::size_t state, Workspace& w) const {
  ++w.judged;
  auto& near = w.broad_phase.near[state];
  if (tuning_.learning) {
    const auto likeliest = std::max_element(
        near.begin(), near.end(), [&](std::int32_t a, std::int32_t b) { return w.hits[at(a)] < w.hits[at(b)]; });
    std::swap(near.front(), *likeliest);
  }
  for (std::size_t k = 0; k < near.size(); ++k) {
    if (!collides(at(near[k]), state, w)) continue;
    w.counters.skipped += static_cast<long>(near.size() - k - 1);
    return false;
  }
  return true;
}

bool CheckerCore::is_found_colliding(std::size_t state, Workspace& w) const {
  ++w.judged;
  bool found = (w.broad_phase.overlapping & 1U << state) != 0;  // then no pair is near
  for (const std::int32_t pair : w.broad_phase.near[state]) {
    const std::size_t k = at(pair);
    if (found || is_left_out(w.hits[k], w.tests[k], w.left_out)) {
      ++w.counters.skipped;
    } else {
      found = collides(k, state, w);
    }
  }
  return found;
}

std::int32_t CheckerCore::first_collision(std::size_t state, Workspace& w) const {
  ++w.judged;
  auto& near = w.broad_phase.near[state];
  std::sort(near.begin(), near.end());
  for (std::size_t k = 0; k < near.size(); ++k) {
    if (!collides(at(near[k]), state, w)) continue;
    w.counters.skipped += static_cast<long>(near.size() - k - 1);
    return near[k];
  }
  return -1;
}

void CheckerCore::begin_posing(const Kinematics& kinematics, Workspace& w) const {
  w.state_links = nullptr;
  w.configurations = {w.columns.data(), at(kinematics.width())};
  if (w.posed_by == kinematics.id()) return;
  w.columns.resize(kBlockGroups * at(kinematics.width()));
  w.configurations.columns = w.columns.data();
  w.poser.begin(kinematics, needed_.data());
  w.state_poser.begin(kinematics, needed_.data());
  w.float_poser.begin(kinematics, needed_.data());
  w.posed_by = kinematics.id();
}

void CheckerCore::pose_links(std::size_t width, int count, Workspace& w) const {
  const std::size_t links = at(links_) * 12;
  for (std::size_t group = 0; group * kLanes < at(count); ++group) {
    w.poser.pose(&w.columns[group * width], &w.links[group * links]);
  }
}

// Lanes beyond n repeat the last row.
void CheckerCore::load_links(const double* links, std::size_t n, Workspace& w) const {
  const std::size_t size = at(links_) * kPoseStride;
  for (std::size_t state = 0; state < kBlockStates; ++state) {
    const double* from = links + std::min(state, n - 1) * size;
    for (std::size_t link = 0; link < at(links_); ++link) {
      Lanes* to = &w.links[pose_index(at(links_), state / kLanes, link)];
      for (std::size_t i = 0; i < 12; ++i) to[i][state % kLanes] = from[link * kPoseStride + i];
    }
  }
}

void CheckerCore::begin_block(int count, Workspace& w) {
  ++w.block;
  w.block_groups = (at(count) + kLanes - 1) / kLanes;
}

void CheckerCore::find_near(int count, Query query, Workspace& w, bool in_floats) const {
  begin_block(count, w);
  if (!tuning_.bounds) {
    broad_phase_->take_all(count, w.broad_phase);
  } else if (w.state_links != nullptr) {
    broad_phase_->find(w.state_links, w.state, filters_of(tuning_, query), w.broad_phase);
  } else if (in_floats) {
    const std::uint64_t posed_by = w.float_poser.errors_are_fixed() ? w.posed_by : 0;
    broad_phase_->find(w.float_poser.poses(), w.float_poser.errors(), posed_by, w.configurations, count,
                       filters_of(tuning_, query), w.broad_phase);
  } else {
    broad_phase_->find(w.links.data(), w.configurations, count, filters_of(tuning_, query), w.broad_phase);
  }
  const auto& found = w.broad_phase;
  const long overlapping = __builtin_popcount(found.overlapping);
  const long pairs = count * static_cast<long>(pairs_.size());
  w.counters.states += count;
  w.counters.pairs += pairs;
  w.counters.overlaps += overlapping;
  w.counters.boxes += found.boxes_apart;
  w.counters.skipped += found.skipped;
  w.counters.bounds += pairs - found.near_pairs - overlapping - found.boxes_apart - found.skipped;
}

// Calls judge(row_of, count) for every block, once its configurations are loaded; row_of(state): the row of a state.
template <class Judge>
void CheckerCore::each_block(const double* q, std::size_t n, std::size_t width, Workspace& w, Judge judge) const {
  for (std::size_t first = 0; first < n; first += StateOrder::kMostRows) {
    const double* const part = q + first * width;
    const std::size_t rows = std::min(StateOrder::kMostRows, n - first);
    if (tuning_.sorted_states) w.order.find(part, rows, width);
    for (std::size_t i = 0; i < rows; i += kBlockStates) {
      if (first + i > 0) poll_interruption();
      const std::size_t count = std::min<std::size_t>(kBlockStates, rows - i);
      const auto row_of = [&](std::size_t state) { return first + w.order.row(i + state); };
      load_rows<kBlockStates>([&](std::size_t state) { return q + row_of(state) * width; }, count, width,
                              w.columns.data());
      judge(row_of, count);
    }
  }
}

template <class Judge>
void CheckerCore::each_state(const Kinematics& kinematics, const double* q, std::size_t n, Query query, Workspace& w,
                             Judge judge) const {
  const std::size_t width = at(kinematics.width());
  begin_posing(kinematics, w);
  if (n == 1) {
    w.state_links = w.state_poser.pose(q), w.state = q;
    find_near(1, query, w);
    return judge(0, 0);
  }
  const bool can_use_floats = tuning_.bounds && tuning_.float_poses && w.float_poser.is_possible();
  each_block(q, n, width, w, [&](auto row_of, std::size_t count) {
    const bool in_floats = can_use_floats && w.open.floats_pay() && w.float_poser.pose(w.columns.data());
    if (!in_floats) pose_links(width, static_cast<int>(count), w);
    find_near(static_cast<int>(count), query, w, in_floats);
    const unsigned open = in_floats ? w.broad_phase.undecided : 0;
    for (std::size_t state = 0; state < count; ++state) {
      if ((open >> state & 1U) != 0) {
        w.open.add(row_of(state), w.broad_phase.near[state]);
      } else {
        judge(row_of(state), state);
      }
    }
    if (in_floats) w.open.learn(count, static_cast<std::size_t>(__builtin_popcount(open)));
    if (w.open.size() >= kBlockStates) judge_open(q, width, w, judge);
  });
  while (w.open.size() > 0) judge_open(q, width, w, judge);
}

// Poses the states that are tested pair by pair.
template <class Judge>
void CheckerCore::judge_open(const double* q, std::size_t width, Workspace& w, Judge judge) const {
  std::array<std::size_t, kBlockStates> rows;
  BroadPhase::clear_near(w.broad_phase);
  const std::size_t count = w.open.take(rows, w.broad_phase.near);
  load_rows<kBlockStates>([&](std::size_t state) { return q + rows[state] * width; }, count, width, w.columns.data());
  pose_links(width, static_cast<int>(count), w);
  begin_block(static_cast<int>(count), w);
  w.broad_phase.overlapping = 0, w.broad_phase.undecided = (1U << count) - 1;
  w.broad_phase.boxed = tuning_.boxes;  // but those of a last block of one or two states
  for (std::size_t state = 0; state < count; ++state) judge(rows[state], state);
}

template <class Judge>
void CheckerCore::each_state(const double* links, std::size_t n, Workspace& w, Judge judge) const {
  w.state_links = nullptr, w.configurations = {};
  for (std::size_t row = 0; row < n; row += kBlockStates) {
    if (row > 0) poll_interruption();
    const std::size_t count = std::min<std::size_t>(kBlockStates, n - row);
    load_links(links + row * at(links_) * kPoseStride, count, w);
    find_near(static_cast<int>(count), Query::kWhichCollide, w);
    for (std::size_t state = 0; state < count; ++state) judge(row + state, state);
  }
}

void CheckerCore::check_states(const Kinematics& kinematics, const double* q, std::size_t n, std::uint8_t* valid,
                               Workspace& w) const {
  each_state(kinematics, q, n, Query::kAnyCollision, w,
             [&](std::size_t row, std::size_t state) { valid[row] = is_free(state, w); });
}

void CheckerCore::seek_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::uint8_t* not_found,
                                  Workspace& w) const {
  each_state(kinematics, q, n, Query::kAnyCollision, w,
             [&](std::size_t row, std::size_t state) { not_found[row] = !is_found_colliding(state, w); });
}

void CheckerCore::first_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::int32_t* first,
                                   Workspace& w) const {
  each_state(kinematics, q, n, Query::kWhichCollide, w,
             [&](std::size_t row, std::size_t state) { first[row] = first_collision(state, w); });
}

void CheckerCore::first_collisions(const double* links, std::size_t n, std::int32_t* first, Workspace& w) const {
  each_state(links, n, w, [&](std::size_t row, std::size_t state) { first[row] = first_collision(state, w); });
}

void CheckerCore::all_collisions(const double* links, std::size_t n, std::uint8_t* colliding, Workspace& w) const {
  std::fill_n(colliding, n * pairs_.size(), std::uint8_t{0});
  each_state(links, n, w, [&](std::size_t row, std::size_t state) {
    ++w.judged;
    for (const std::int32_t pair : w.broad_phase.near[state]) {
      colliding[row * pairs_.size() + at(pair)] = collides(at(pair), state, w);
    }
  });
}

bool CheckerCore::motion_is_free(const Kinematics& kinematics, const double* q0, const double* q1, long steps,
                                 Workspace& w) const {
  const std::size_t width = at(kinematics.width());
  begin_posing(kinematics, w);
  return is_free_coarse_to_fine<kBlockStates>(q0, q1, steps, width, w.columns.data(), [&](std::size_t states) {
    pose_links(width, static_cast<int>(states), w);
    find_near(static_cast<int>(states), Query::kAnyCollision, w);
    for (std::size_t state = 0; state < states; ++state) {
      if (is_free(state, w)) continue;
      while (++state < states) w.counters.skipped += static_cast<long>(w.broad_phase.near[state].size());
      return false;
    }
    return true;
  });
}

}  // namespace plannercheck
