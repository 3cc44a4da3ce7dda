// What one thread needs to judge states.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/broad_phase.hpp"
#include "broad_phase/float_link_poser.hpp"
#include "broad_phase/poses.hpp"
#include "checking/checker.hpp"
#include "checking/open_states.hpp"
#include "checking/state_blocks.hpp"
#include "checking/state_order.hpp"
#include "math/recent_rate.hpp"
#include "narrow_phase/solid_pair.hpp"
#include "robots/kinematics_lanes.hpp"
#include "robots/state_poser.hpp"

namespace plannercheck {

inline constexpr std::size_t kPoseStride = 16;  // of posed links that are given: row-major 4x4

// Links' poses in doubles: a block of states in lanes, or one state. Pairs are tested at these poses.
class LinkPoses {
 public:
  explicit LinkPoses(std::size_t links = 0) : links_(links), lanes_(kBlockGroups * links * 12) {}

  // Where the poses of a block are to be written (state_block.hpp).
  Lanes* block() {
    is_of_one_state_ = false;
    return lanes_.data();
  }
  // Takes the poses of one state, which have to outlive it.
  void set(const PoseColumns* of_state) { is_of_one_state_ = true, of_state_ = of_state; }

  bool are_of_one_state() const { return is_of_one_state_; }
  const Lanes* lanes(std::size_t group, std::size_t link) const { return &lanes_[pose_index(links_, group, link)]; }

  PoseColumns of(std::size_t link, std::size_t state) const {
    if (is_of_one_state_) return of_state_[link];
    const Lanes* const pose = lanes(state / kLanes, link);
    const std::size_t lane = state % kLanes;
    // Built in registers: a wide load after narrower stores would be a store-forwarding stall.
    PoseColumns out;
    for (std::size_t k = 0; k < 4; ++k) out.column[k] = Double4{pose[k][lane], pose[4 + k][lane], pose[8 + k][lane], 0};
    return out;
  }

 private:
  std::size_t links_;
  std::vector<Lanes> lanes_;
  bool is_of_one_state_ = false;
  const PoseColumns* of_state_ = nullptr;
};

// The posers of one kinematics, and what they have posed.
struct Posing {
  std::uint64_t kinematics = 0;  // for which they are prepared
  LinkPoser links_in_lanes;
  StatePoser links_of_state;
  FloatLinkPoser links_in_floats;
  std::vector<Lanes> columns;  // a block's configurations
  std::size_t width = 0;

  BlockConfigurations configurations() const { return {columns.data(), width}; }
};

// The states of a block, a bit each, in which look-ups say that a body is clear of a set; looked up for the whole block
// when one state asks.
struct ClearStates {
  std::uint64_t block = 0;
  std::uint32_t states = 0;
};

struct CheckerCore::Workspace {
  CheckerCounters counters;
  StateOrder order;  // of the rows of a set
  Posing posing;
  LinkPoses links;       // of the states that are judged
  RoundedPoses rounded;  // those of a block, for the filters
  SingleState single;
  BroadPhase::Workspace broad_phase;
  OpenStates open;                      // of the set, left open by poses in floats
  Found opened;                         // the same of a block of them
  std::vector<PairMemory> memories;     // per pair
  std::vector<SolidHistory> histories;  // per pair of solids
  std::uint64_t block = 0;              // counts the blocks of states
  std::size_t block_groups = 0;         // of lanes, in this one
  std::vector<ClearStates> clear;       // per pair, if there are sets
  std::vector<RecentRate> collisions;   // per pair: how often it collides when it is tested
};

}  // namespace plannercheck
