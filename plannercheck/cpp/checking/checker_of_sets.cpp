// The checker's tests of pairs whose hulls decide nothing: sets of parts and half-spaces.
#include "broad_phase/part_clearances.hpp"
#include "checking/checker_workspace.hpp"
#include "narrow_phase/pair_kernels.hpp"
#include "narrow_phase/part_pair.hpp"

namespace plannercheck {

double CheckerCore::inflation(std::size_t pair) const {
  return bodies_[at(pairs_[pair][0])].body->inflation_radius + bodies_[at(pairs_[pair][1])].body->inflation_radius;
}

// Looks up all states of a block at once, in lanes, because most states ask for most pairs.
bool CheckerCore::is_clear_of_parts(std::size_t pair, std::size_t state, Workspace& w) const {
  if (w.links.are_of_one_state()) {
    const double margin = inflation(pair) * kRadiusStretch;
    const PartClearances::Look look = clearances_->look(pairs_[pair][0], pairs_[pair][1]);
    return look.grid != nullptr && PartClearances::is_clear(look, w.links.of(at(look.link), state).by_rows().m, margin);
  }
  ClearStates& known = w.clear[pair];
  if (known.block != w.block) known = {w.block, clear_states(pair, w)};
  return (known.states >> state & 1U) != 0;
}

std::uint32_t CheckerCore::clear_states(std::size_t pair, const Workspace& w) const {
  const PartClearances::Look look = clearances_->look(pairs_[pair][0], pairs_[pair][1]);
  if (look.grid == nullptr) return 0;
  const double margin = inflation(pair) * kRadiusStretch;
  std::uint32_t clear = 0;
  for (std::size_t group = 0; group < w.block_groups; ++group) {
    clear |= PartClearances::clear_lanes(look, w.links.lanes(group, at(look.link)), margin) << (group * kLanes);
  }
  return clear;
}

// The hull of a set of parts decides nothing, so it is not tested.
bool CheckerCore::parts_share(std::size_t pair, std::size_t state, Workspace& w) const {
  const std::size_t body_a = at(pairs_[pair][0]), body_b = at(pairs_[pair][1]);
  if (tuning_.bounds && is_clear_of_parts(pair, state, w)) {
    ++w.counters.bounds;
    return false;
  }
  const PosedPolytope a{bodies_[body_a].body.get(), posed(body_a, state, w)};
  const PosedPolytope b{bodies_[body_b].body.get(), posed(body_b, state, w)};
  SolidOptions options;
  options.part_trees = tuning_.part_trees;
  const SolidContact found =
      kPairKernels[kinds_[pair]].contact(a, b, w.histories[pair].contact, w.counters.pair, options, nullptr);
  ++w.counters.stages[static_cast<std::size_t>(Stage::kSolver)];
  if (found) w.histories[pair].contact = found;
  return static_cast<bool>(found);
}

bool CheckerCore::half_space_shared(std::size_t pair, std::size_t state, Workspace& w) const {
  const std::size_t body_a = at(pairs_[pair][0]), body_b = at(pairs_[pair][1]);
  ++w.counters.stages[static_cast<std::size_t>(Stage::kSolver)];
  const PosedPolytope a{bodies_[body_a].body.get(), posed(body_a, state, w)};
  const PosedPolytope b{bodies_[body_b].body.get(), posed(body_b, state, w)};
  return kPairKernels[kinds_[pair]].share(a, b, tuning_, w.counters.pair);
}

}  // namespace plannercheck
