// Verdicts for sets of configurations: blocks of states are posed and bounded in lanes, then the pairs left are tested.
//
// In: posed links (from the kinematics kernel or given), bodies on links, pairs of bodies. Out: for each configuration
// whether some pair shares a point, and which. Immutable: each thread brings a workspace, which holds all statistics of
// earlier states. This header has no lanes, whose number differs between instruction sets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "broad_phase/apart_cells.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/sampled_poses.hpp"
#include "narrow_phase/intersection.hpp"
#include "robots/kinematics.hpp"

namespace plannercheck {

// Every pair of every state is counted once, by what decided it.
struct CheckerCounters {
  long states = 0, pairs = 0;
  long bounds = 0;    // balls that do not meet, obstacles' boxes out of range, static pairs that are apart
  long boxes = 0;     // boxes separated by a face plane
  long overlaps = 0;  // balls inside one body that meet a box inside the other
  std::array<long, kStages> stages{};  // of the pair test
  long trees = 0;                      // trees of solids, before their hulls were tested
  long skipped = 0;                    // the state's verdict was already known
  PairCounters pair;
};

CheckerCounters& operator+=(CheckerCounters& sum, const CheckerCounters& more);

// What saves work, by the names of `Tuning` in Python. Verdicts depend on none of it.
struct Tuning : PairOptions {
  bool bounds = true;  // balls and the tree of obstacles; bounds of speed along motions
  bool boxes = true;
  bool overlaps = true;       // of balls inside bodies with boxes inside others, where any collision decides
  bool learning = true;       // tests the pair that collided most often first, where any collision decides
  bool sorted_states = true;  // like states of a set are judged together
  bool float_poses = true;    // for the filters of sets; those in doubles where a pair is left
  bool thin_tubes = true;     // along curves, tubes as thin as rounding count as rounding
  bool hollows = true;        // along motions, parts in the hollow of a solid by their distance from all of it
  bool covers = true;         // of pieces of trajectories, several are tried by one straight motion
  bool halves = true;         // curves too long for one grid of few states are cut in halves; not in Python's record
};

// What a state's verdict depends on: whether any pair shares a point, or which ones.
enum class Query { kAnyCollision, kWhichCollide };

class BroadPhase;
class PartClearances;
struct BlockConfigurations;
struct FloatBlock;
struct Found;

class CheckerCore {
 public:
  // `sampled`: states that determine which bodies are tested together; they have no effect on verdicts. `in_cells`:
  // pairs of bodies on links that are apart wherever their cells say so.
  CheckerCore(std::vector<GeometryObject> bodies, std::vector<std::array<std::int32_t, 2>> pairs, std::int32_t links,
              Tuning tuning, std::shared_ptr<const SampledPoses> sampled, const std::vector<PairsInCells>& in_cells);

  // The poses, bounds, learnt order and counts of one thread.
  struct Workspace;
  std::shared_ptr<Workspace> new_workspace() const;
  // The counts since the last call.
  static CheckerCounters take_counters(Workspace& workspace);

  std::size_t body_count() const { return bodies_.size(); }
  std::size_t pair_count() const { return pairs_.size(); }
  std::int32_t link_count() const { return links_; }

  // A body's pose, its link's times its placement: the bits of every verdict. `links`: their poses, row-major 4x4.
  Pose body_pose(std::size_t body, const double* links) const;

  // Whether no pair shares a point, for each of n configurations (n, width).
  void check_states(const Kinematics& kinematics, const double* q, std::size_t n, std::uint8_t* valid,
                    Workspace& workspace) const;
  // Looks for collisions where they are cheap to find: pairs that hardly ever collided when they were tested are left
  // out. A state that is marked 0 collides for sure; one that is marked 1 may collide all the same.
  void seek_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::uint8_t* not_found,
                       Workspace& workspace) const;
  // The index of the first pair in the table that shares a point, or −1.
  void first_collisions(const Kinematics& kinematics, const double* q, std::size_t n, std::int32_t* first,
                        Workspace& workspace) const;
  // As above, for links that are already posed: n times link_count() matrices, row-major 4x4.
  void first_collisions(const double* links, std::size_t n, std::int32_t* first, Workspace& workspace) const;
  // Tests every pair: colliding[i * pair_count() + k] is for configuration i and pair k.
  void all_collisions(const double* links, std::size_t n, std::uint8_t* colliding, Workspace& workspace) const;

  // Calls visit(row, pairs) once for each row, in any order, with the pairs that no filter proves apart.
  using NearVisitor = std::function<void(std::size_t row, const std::vector<std::int32_t>& pairs)>;
  void near_pairs(const Kinematics& kinematics, const double* q, std::size_t n, const NearVisitor& visit,
                  Workspace& workspace) const;
  void near_pairs(const double* links, std::size_t n, const NearVisitor& visit, Workspace& workspace) const;

  // Whether the states (1 − t) q0 + t q1 at t = 0, 1/steps, …, 1 are all free; coarse to fine, to meet a collision
  // early.
  bool motion_is_free(const Kinematics& kinematics, const double* q0, const double* q1, long steps,
                      Workspace& workspace) const;

 private:
  std::vector<GeometryObject> bodies_;
  std::vector<std::array<std::int32_t, 2>> pairs_;  // A, B
  std::int32_t links_;
  std::vector<Kind> kinds_;            // per pair
  std::vector<unsigned char> needed_;  // links that carry a body of some pair
  Tuning tuning_;
  std::shared_ptr<const BroadPhase> broad_phase_;
  std::shared_ptr<const PartClearances> clearances_;

  // Each calls judge(row, state of the block, what the filters found) for every row while the row's links are posed.
  template <class Judge>
  void each_state(const Kinematics& kinematics, const double* q, std::size_t n, Query query, Workspace& workspace,
                  Judge judge) const;
  template <class Judge>
  void each_in_blocks(const double* q, std::size_t n, Query query, Workspace& workspace, Judge judge) const;
  template <class RowOf, class Judge>
  void judge_in_floats(RowOf row_of, std::size_t count, Query query, Workspace& workspace, Judge judge) const;
  template <class Judge>
  void judge_open(const double* q, Workspace& workspace, Judge judge) const;
  template <class Judge>
  void each_state(const double* links, std::size_t n, Workspace& workspace, Judge judge) const;

  void begin_posing(const Kinematics& kinematics, Workspace& workspace) const;
  static void begin_block(std::size_t count, Workspace& workspace);
  void pose_block(std::size_t count, Workspace& workspace) const;
  void load_links(const double* links, std::size_t n, Workspace& workspace) const;
  FloatBlock rounded_block(BlockConfigurations q, std::size_t count, Workspace& workspace) const;
  template <class Poses>
  Found& filter(Poses& poses, Query query, Workspace& workspace) const;
  bool are_boxed(const Workspace& workspace) const;
  Pose posed(std::size_t body, std::size_t state, const Workspace& workspace) const;
  bool collides(std::size_t pair, std::size_t state, Workspace& workspace) const;
  // The tests behind `collides`, by the kind of the pair.
  using PairTest = bool (CheckerCore::*)(std::size_t pair, std::size_t state, Workspace& workspace) const;
  static const KindTable<PairTest> kPairTests;
  template <bool are_hulls>
  bool hulls_share(std::size_t pair, std::size_t state, Workspace& workspace) const;
  bool is_clear_of_parts(std::size_t pair, std::size_t state, Workspace& workspace) const;
  double inflation(std::size_t pair) const;  // of both bodies
  std::uint32_t clear_states(std::size_t pair, const Workspace& workspace) const;
  bool parts_share(std::size_t pair, std::size_t state, Workspace& workspace) const;
  bool half_space_shared(std::size_t pair, std::size_t state, Workspace& workspace) const;
  bool is_free(Found& found, std::size_t state, Workspace& workspace) const;
  [[gnu::noinline]] bool no_pair_collides(std::vector<std::int32_t>& near, std::size_t state,
                                          Workspace& workspace) const;
  bool is_found_colliding(Found& found, std::size_t state, Workspace& workspace) const;
  std::int32_t first_collision(std::vector<std::int32_t>& near, std::size_t state, Workspace& workspace) const;
};

}  // namespace plannercheck
