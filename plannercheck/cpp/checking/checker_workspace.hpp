// What one thread needs to judge states.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/broad_phase.hpp"
#include "broad_phase/float_link_poser.hpp"
#include "checking/checker.hpp"
#include "checking/open_states.hpp"
#include "checking/state_blocks.hpp"
#include "checking/state_order.hpp"
#include "narrow_phase/solid_pair.hpp"
#include "robots/kinematics_lanes.hpp"
#include "robots/state_poser.hpp"

namespace plannercheck {

// Whether a group of bodies is far from all parts of its set, in the state judged when it was looked at.
struct GroupLook {
  std::uint64_t judged = 0;
  bool is_far = false;
};

// The states of a block, a bit each, in which look-ups say that a body is clear of a set; known once one of them has
// been asked for.
struct ClearStates {
  std::uint64_t block = 0;
  std::uint32_t states = 0;
};

struct CheckerCore::Workspace {
  CheckerCounters counters;
  std::vector<Lanes> columns, links;         // of a block's groups: configurations and link poses
  StateOrder order;                          // of the rows of a set
  const PoseColumns* state_links = nullptr;  // the poses of a single state, if they are not among those
  const double* state = nullptr;             // its configuration
  BlockConfigurations configurations;        // of a block, if they are known
  LinkPoser poser;
  StatePoser state_poser;
  FloatLinkPoser float_poser;
  OpenStates open;             // of the set, left open by poses in floats
  std::uint64_t posed_by = 0;  // the kinematics for which the posers are prepared
  BroadPhase::Workspace broad_phase;
  std::vector<PairMemory> memories;        // per pair
  std::vector<SolidHistory> histories;     // per pair of solids
  std::uint64_t judged = 0;                // counts the states that are judged
  std::vector<GroupLook> groups;           // of parts: what the last look at each has shown
  std::uint64_t block = 0;                 // counts the blocks of states
  std::size_t block_groups = 0;            // of lanes, in this one
  std::vector<ClearStates> clear;          // per pair, if there are sets
  std::vector<std::uint32_t> hits, tests;  // per pair: collisions found, pair tests
  std::uint32_t left_out = 0;              // counts the tests that `seek_collisions` leaves out
};

}  // namespace plannercheck
