#include "broad_phase/broad_phase.hpp"

#include <type_traits>
#include <utility>

namespace plannercheck {

BroadPhase::BroadPhase(const std::vector<GeometryObject>& bodies, const std::vector<std::array<std::int32_t, 2>>& pairs,
                       const std::vector<bool>& permanent, std::shared_ptr<const SampledPoses> sampled,
                       const std::vector<PairsInCells>& in_cells)
    : pairs_(pairs.size()), search_(bodies, pairs, std::move(sampled), in_cells), bounds_(bodies, pairs) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (permanent[k]) permanent_pairs_.push_back(static_cast<std::int32_t>(k));
  }
}

BroadPhase::Workspace BroadPhase::new_workspace() const {
  Workspace w{search_.new_workspace(), bounds_.posed<FloatBlock>(), bounds_.posed<SingleState>(), {}, {}, {}};
  w.found.near.reserve(pairs_);
  return w;
}

template <class Poses>
void BroadPhase::find(Poses& poses, Filters filters, Workspace& w) const {
  w.found.begin();
  if (!filters.bounds) return take_all(poses.all(), w.found);
  if (filters.overlaps && !permanent_pairs_.empty()) return take_overlapping(poses.all(), w.found);
  w.posed(poses).begin(poses);
  w.overlap = {};
  const bool learns = filters.overlaps && filters.learning;
  if (learns) try_likely(poses, w);
  if (w.found.overlapping != poses.all()) find_by_bounds(poses, filters, w);
  if (learns) w.likely.learn(w.overlap.pair, poses.count, w.overlap.states);
}

void BroadPhase::take_all(unsigned states, Found& found) const {
  for (std::size_t k = 0; k < pairs_; ++k) found.near.add(static_cast<std::int32_t>(k), states);
}

// One pair decides every state.
void BroadPhase::take_overlapping(unsigned states, Found& found) const {
  found.overlapping = states;
  found.skipped = __builtin_popcount(states) * (static_cast<long>(pairs_) - 1);
}

// An overlap is a proof, so these pairs need no search first.
template <class Poses>
void BroadPhase::try_likely(Poses& poses, Workspace& w) const {
  w.likely.try_each([&](std::size_t pair) {
    take_overlap(pair, bounds_.by_inner_shapes(pair, w.posed(poses)).overlap & poses.all(), w);
    return w.found.overlapping == poses.all();
  });
  w.found.skipped = __builtin_popcount(w.found.overlapping) * (static_cast<long>(pairs_) - 1);
}

void BroadPhase::take_overlap(std::size_t pair, unsigned states, Workspace& w) {
  const int count = __builtin_popcount(states);
  if (count > w.overlap.states) w.overlap = {pair, count};
  w.found.overlapping |= states;
}

// Goes step by step, because if any collision decides, the candidates of one step mostly decide all states.
template <class Poses>
void BroadPhase::find_by_bounds(Poses& poses, Filters filters, Workspace& w) const {
  const std::size_t steps = search_.begin(poses, w.search);
  Found& found = w.found;
  std::size_t filtered = 0;
  for (std::size_t step = 0; step < steps && found.overlapping != poses.all(); ++step) {
    const unsigned before = found.overlapping;
    search_.find(step, poses, poses.all() & ~before, w.search);
    for (; filtered < w.search.candidates.size(); ++filtered) filter(w.search.candidates[filtered], poses, filters, w);
    // One of the pairs that overlap is among the candidates, which `sort_by_state` counts.
    found.skipped += __builtin_popcount(found.overlapping & ~before) * (static_cast<long>(w.search.unseen) - 1);
  }
  sort_by_state(poses, filters, w);
}

// Boxes go first, since they decide more.
template <class Poses>
void BroadPhase::filter(Candidate& candidate, Poses& poses, Filters filters, Workspace& w) const {
  unsigned open = candidate.states & ~w.found.overlapping;
  if constexpr (std::is_same_v<Poses, FloatBlock>) {
    if (filters.boxes && open != 0) {
      drop(candidate, open & bounds_.by_faces(at(candidate.pair), w.in_block).apart, w.found);
      open &= candidate.states;
    }
  }
  if (!filters.overlaps || open == 0) return;
  take_overlap(at(candidate.pair), open & bounds_.by_inner_shapes(at(candidate.pair), w.posed(poses)).overlap, w);
}

void BroadPhase::drop(Candidate& candidate, unsigned apart, Found& found) {
  found.boxes_apart += __builtin_popcount(apart);
  candidate.states &= ~apart;
}

// Planes along edges come last, for pairs that nothing else has decided.
template <class Poses>
void BroadPhase::sort_by_state(Poses& poses, Filters filters, Workspace& w) const {
  Found& found = w.found;
  const auto open = [&](Candidate& candidate) {
    found.skipped += __builtin_popcount(candidate.states & found.overlapping);
    candidate.states &= ~found.overlapping;
    return candidate.states != 0;
  };
  for (const std::int32_t pair : permanent_pairs_) found.near.add(pair, poses.all());
  for (Candidate& candidate : w.search.candidates) {
    if (!open(candidate)) continue;
    if constexpr (std::is_same_v<Poses, FloatBlock>) {
      if (filters.boxes) {
        drop(candidate, candidate.states & bounds_.by_edges(at(candidate.pair), w.in_block).apart, found);
      }
    }
    found.near.add(candidate.pair, candidate.states);
  }
  for (Candidate& candidate : w.search.unboxed) {
    if (open(candidate)) found.near.add(candidate.pair, candidate.states);
  }
}

template void BroadPhase::find(FloatBlock&, Filters, Workspace&) const;
template void BroadPhase::find(SingleState&, Filters, Workspace&) const;

}  // namespace plannercheck
