// The checker's loops over states: posed and filtered a block at a time, or one by one where there are few, then judged
// one after the other.
//
// In: rows of configurations, or posed links. Out: what is asked of each. Sets are posed in floats first, and only the
// states that the filters leave open in doubles, in blocks of their own (open_states.hpp).
#include <algorithm>
#include <utility>

#include "checking/checker_workspace.hpp"
#include "math/interruption.hpp"

namespace plannercheck {
namespace {

// Up to so many rows are judged one by one: lanes over states would be mostly empty (measured).
constexpr std::size_t kSingleRows = 2;

// A pair seldom collides if fewer than one in so many tests finds a collision (measured, as are the rates that
// `Workspace` begins with).
constexpr std::uint32_t kSeldom = 8;

}  // namespace

// ----- poses

void CheckerCore::begin_posing(const Kinematics& kinematics, Workspace& w) const {
  Posing& posing = w.posing;
  if (posing.kinematics == kinematics.id()) return;
  posing.width = at(kinematics.width());
  posing.columns.resize(kBlockGroups * posing.width);
  posing.links_in_lanes.begin(kinematics, needed_.data());
  posing.links_of_state.begin(kinematics, needed_.data());
  posing.links_in_floats.begin(kinematics, needed_.data());
  posing.kinematics = kinematics.id();
}

void CheckerCore::begin_block(std::size_t count, Workspace& w) {
  ++w.block;
  w.block_groups = (count + kLanes - 1) / kLanes;
}

// Poses the block in doubles.
void CheckerCore::pose_block(std::size_t count, Workspace& w) const {
  begin_block(count, w);
  Lanes* const links = w.links.block();
  for (std::size_t group = 0; group < w.block_groups; ++group) {
    w.posing.links_in_lanes.pose(&w.posing.columns[group * w.posing.width], links + pose_index(at(links_), group, 0));
  }
}

// Lanes beyond n repeat the last row.
void CheckerCore::load_links(const double* links, std::size_t n, Workspace& w) const {
  begin_block(n, w);
  const std::size_t size = at(links_) * kPoseStride;
  Lanes* const block = w.links.block();
  for (std::size_t state = 0; state < kBlockStates; ++state) {
    const double* from = links + std::min(state, n - 1) * size;
    for (std::size_t link = 0; link < at(links_); ++link) {
      Lanes* to = block + pose_index(at(links_), state / kLanes, link);
      for (std::size_t i = 0; i < 12; ++i) to[i][state % kLanes] = from[link * kPoseStride + i];
    }
  }
}

FloatBlock CheckerCore::rounded_block(BlockConfigurations q, std::size_t count, Workspace& w) const {
  w.rounded.begin(w.links.lanes(0, 0));
  for (std::size_t link = 0; link < needed_.size(); ++link) {
    if (needed_[link] != 0) w.rounded.round(link);
  }
  return w.rounded.block(q, static_cast<int>(count));
}

// ----- filters

template <class Poses>
Found& CheckerCore::filter(Poses& poses, Query query, Workspace& w) const {
  const bool any = query == Query::kAnyCollision;
  broad_phase_->find(poses, {tuning_.bounds, tuning_.overlaps && any, tuning_.boxes, tuning_.learning}, w.broad_phase);
  Found& found = w.broad_phase.found;
  const long pairs = poses.count * static_cast<long>(pairs_.size());
  const long overlapping = __builtin_popcount(found.overlapping);
  w.counters.states += poses.count;
  w.counters.pairs += pairs;
  w.counters.overlaps += overlapping;
  w.counters.boxes += found.boxes_apart;
  w.counters.skipped += found.skipped;
  w.counters.bounds += pairs - found.near.count() - overlapping - found.boxes_apart - found.skipped;
  return found;
}

// ----- verdicts of one state

// Only this test is inlined where states are judged, because the filters decide most states.
inline bool CheckerCore::is_free(Found& found, std::size_t state, Workspace& w) const {
  if ((found.near.states() >> state & 1U) != 0) return no_pair_collides(found.near.of(state), state, w);
  return (found.overlapping >> state & 1U) == 0;
}

// The pair that collides most often goes first.
bool CheckerCore::no_pair_collides(std::vector<std::int32_t>& near, std::size_t state, Workspace& w) const {
  if (tuning_.learning) {
    const auto is_below = [&](std::int32_t a, std::int32_t b) {
      return w.collisions[at(b)].is_above(w.collisions[at(a)]);
    };
    std::swap(near.front(), *std::max_element(near.begin(), near.end(), is_below));
  }
  for (std::size_t k = 0; k < near.size(); ++k) {
    if (!collides(at(near[k]), state, w)) continue;
    w.counters.skipped += static_cast<long>(near.size() - k - 1);
    return false;
  }
  return true;
}

// Here a missed collision costs only time, so a pair that seldom collides is left out, except now and then.
bool CheckerCore::is_found_colliding(Found& found, std::size_t state, Workspace& w) const {
  bool collided = (found.overlapping & 1U << state) != 0;  // then no pair is near
  for (const std::int32_t pair : found.near.of(state)) {
    RecentRate& rate = w.collisions[at(pair)];
    if (collided || !(rate.is_at_least_one_in(kSeldom) || rate.is_due())) {
      ++w.counters.skipped;
    } else {
      collided = collides(at(pair), state, w);
    }
  }
  return collided;
}

std::int32_t CheckerCore::first_collision(std::vector<std::int32_t>& near, std::size_t state, Workspace& w) const {
  std::sort(near.begin(), near.end());
  for (std::size_t k = 0; k < near.size(); ++k) {
    if (!collides(at(near[k]), state, w)) continue;
    w.counters.skipped += static_cast<long>(near.size() - k - 1);
    return near[k];
  }
  return -1;
}

// ----- loops: judge(row, state of the block, what the filters found)

template <class Judge>
void CheckerCore::each_state(const Kinematics& kinematics, const double* q, std::size_t n, Query query, Workspace& w,
                             Judge judge) const {
  begin_posing(kinematics, w);
  const std::size_t width = w.posing.width;
  if (n > kSingleRows) return each_in_blocks(q, n, query, w, judge);
  for (std::size_t row = 0; row < n; ++row) {
    const PoseColumns* const links = w.posing.links_of_state.pose(q + row * width);
    w.links.set(links);
    w.single.begin(links, q + row * width);
    judge(row, 0, filter(w.single, query, w));
  }
}

template <class Judge>
void CheckerCore::each_in_blocks(const double* q, std::size_t n, Query query, Workspace& w, Judge judge) const {
  Posing& posing = w.posing;
  const bool can_use_floats = tuning_.bounds && tuning_.float_poses && posing.links_in_floats.is_possible();
  for (std::size_t first = 0; first < n; first += StateOrder::kMostRows) {
    const std::size_t rows = std::min(StateOrder::kMostRows, n - first);
    if (tuning_.sorted_states) w.order.find(q + first * posing.width, rows, posing.width);
    for (std::size_t i = 0; i < rows; i += kBlockStates) {
      if (first + i > 0) poll_interruption();
      const std::size_t count = std::min<std::size_t>(kBlockStates, rows - i);
      const auto row_of = [&](std::size_t state) { return first + w.order.row(i + state); };
      load_rows<kBlockStates>([&](std::size_t state) { return q + row_of(state) * posing.width; }, count, posing.width,
                              posing.columns.data());
      if (can_use_floats && w.open.floats_pay() && posing.links_in_floats.pose(posing.columns.data())) {
        judge_in_floats(row_of, count, query, w, judge);
        if (w.open.size() >= kBlockStates) judge_open(q, w, judge);
      } else {
        pose_block(count, w);
        FloatBlock block = rounded_block(posing.configurations(), count, w);
        Found& found = filter(block, query, w);
        for (std::size_t state = 0; state < count; ++state) judge(row_of(state), state, found);
      }
    }
  }
  while (w.open.size() > 0) judge_open(q, w, judge);
}

// Judges the states that the filters decide, and keeps the others.
template <class RowOf, class Judge>
void CheckerCore::judge_in_floats(RowOf row_of, std::size_t count, Query query, Workspace& w, Judge judge) const {
  FloatBlock block = w.posing.links_in_floats.block(w.posing.configurations(), static_cast<int>(count));
  Found& found = filter(block, query, w);
  const unsigned open = found.near.states();
  for (std::size_t state = 0; state < count; ++state) {
    if ((open >> state & 1U) != 0) {
      w.open.add(row_of(state), found.near.of(state));
    } else {
      judge(row_of(state), state, found);
    }
  }
  w.open.learn(count, static_cast<std::size_t>(__builtin_popcount(open)));
}

// Poses a block of the states that are tested pair by pair.
template <class Judge>
void CheckerCore::judge_open(const double* q, Workspace& w, Judge judge) const {
  std::array<std::size_t, kBlockStates> rows;
  const std::size_t count = w.open.take(rows, w.opened), width = w.posing.width;
  load_rows<kBlockStates>([&](std::size_t state) { return q + rows[state] * width; }, count, width,
                          w.posing.columns.data());
  pose_block(count, w);
  for (std::size_t state = 0; state < count; ++state) judge(rows[state], state, w.opened);
}

template <class Judge>
void CheckerCore::each_state(const double* links, std::size_t n, Workspace& w, Judge judge) const {
  for (std::size_t row = 0; row < n; row += kBlockStates) {
    if (row > 0) poll_interruption();
    const std::size_t count = std::min<std::size_t>(kBlockStates, n - row);
    load_links(links + row * at(links_) * kPoseStride, count, w);
    FloatBlock block = rounded_block({}, count, w);
    Found& found = filter(block, Query::kWhichCollide, w);
    for (std::size_t state = 0; state < count; ++state) judge(row + state, state, found);
  }
}

// ----- what is asked

void CheckerCore::check_states(const Kinematics& kinematics, const double* q, std::size_t n, std::uint8_t* valid,
                               Workspace& w) const {
  each_state(kinematics, q, n, Query::kAnyCollision, w,
             [&](std::size_t row, std::size_t state, Found& found) { valid[row] = is_free(found, state, w); });
}

void CheckerCore::seek_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::uint8_t* not_found,
                                  Workspace& w) const {
  each_state(kinematics, q, n, Query::kAnyCollision, w, [&](std::size_t row, std::size_t state, Found& found) {
    not_found[row] = !is_found_colliding(found, state, w);
  });
}

void CheckerCore::first_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::int32_t* first,
                                   Workspace& w) const {
  each_state(kinematics, q, n, Query::kWhichCollide, w, [&](std::size_t row, std::size_t state, Found& found) {
    first[row] = first_collision(found.near.of(state), state, w);
  });
}

void CheckerCore::first_collisions(const double* links, std::size_t n, std::int32_t* first, Workspace& w) const {
  each_state(links, n, w, [&](std::size_t row, std::size_t state, Found& found) {
    first[row] = first_collision(found.near.of(state), state, w);
  });
}

void CheckerCore::all_collisions(const double* links, std::size_t n, std::uint8_t* colliding, Workspace& w) const {
  std::fill_n(colliding, n * pairs_.size(), std::uint8_t{0});
  each_state(links, n, w, [&](std::size_t row, std::size_t state, Found& found) {
    for (const std::int32_t pair : found.near.of(state)) {
      colliding[row * pairs_.size() + at(pair)] = collides(at(pair), state, w);
    }
  });
}

void CheckerCore::near_pairs(const Kinematics& kinematics, const double* q, std::size_t n, const NearVisitor& visit,
                             Workspace& w) const {
  each_state(kinematics, q, n, Query::kWhichCollide, w,
             [&](std::size_t row, std::size_t state, Found& found) { visit(row, found.near.of(state)); });
}

void CheckerCore::near_pairs(const double* links, std::size_t n, const NearVisitor& visit, Workspace& w) const {
  each_state(links, n, w, [&](std::size_t row, std::size_t state, Found& found) { visit(row, found.near.of(state)); });
}

bool CheckerCore::motion_is_free(const Kinematics& kinematics, const double* q0, const double* q1, long steps,
                                 Workspace& w) const {
  begin_posing(kinematics, w);
  return is_free_coarse_to_fine<kBlockStates>(
      q0, q1, steps, w.posing.width, w.posing.columns.data(), [&](std::size_t states) {
        pose_block(states, w);
        FloatBlock block = rounded_block(w.posing.configurations(), states, w);
        Found& found = filter(block, Query::kAnyCollision, w);
        for (std::size_t state = 0; state < states; ++state) {
          if (is_free(found, state, w)) continue;
          while (++state < states) w.counters.skipped += static_cast<long>(found.near.of(state).size());
          return false;
        }
        return true;
      });
}

}  // namespace plannercheck
