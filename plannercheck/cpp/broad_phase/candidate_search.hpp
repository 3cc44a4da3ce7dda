// Which pairs of bodies are candidates in a block of states, or in one state: bounding balls are compared with each
// other and with obstacles' boxes, and pairs in cells are looked up.
//
// In: posed links, the states that are open. Out: pairs, each with the states in which its bounds meet. For a block, in
// lanes over states, the search has steps: groups of movers against obstacles, or against a tree of many obstacles,
// then movers against each other, against half-spaces and against height fields. So filters may decide states between
// two steps. For one state, in lanes over pairs, there is one step.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "bodies/lazy_value.hpp"
#include "broad_phase/apart_cells.hpp"
#include "broad_phase/body_slices.hpp"
#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/float_boxes.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/height_filter.hpp"
#include "broad_phase/mover_groups.hpp"
#include "broad_phase/obstacle_tree.hpp"
#include "broad_phase/plane_filter.hpp"
#include "broad_phase/posed_balls.hpp"
#include "broad_phase/poses.hpp"
#include "broad_phase/single_state_filter.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

// A pair and the states in which it may touch, one bit each.
struct Candidate {
  std::int32_t pair;
  unsigned states;
};

class CandidateSearch {
 public:
  CandidateSearch(const std::vector<GeometryObject>& bodies, const std::vector<std::array<std::int32_t, 2>>& pairs,
                  std::shared_ptr<const SampledPoses> sampled, const std::vector<PairsInCells>& in_cells);

  // Precomputed where balls have the same radii in all states: radii of movers and slices, and thresholds of squared
  // distances, by mover for obstacles and by pair among movers.
  struct FixedRadii {
    std::uint64_t always = 0;  // as in FloatBlock
    std::vector<float> movers, slices, from_obstacles, of_pairs;
  };

  struct Workspace {
    const MoverGroups* groups = nullptr;
    std::vector<BoxInStates> around;  // by group
    std::vector<PosedBalls> balls, slices;
    FixedRadii fixed;
    bool are_fixed = false;  // in this block
    SingleStateFilter::Workspace single_state_filter;
    std::vector<std::int32_t> found, reached;  // obstacles near the ball: in one state, in any state
    std::vector<unsigned> states;              // per obstacle, those in which it is near; 0 between searches
    // The candidates found so far. `unboxed`: pairs with half-spaces and height fields, which no other filter decides.
    std::vector<Candidate> candidates, unboxed;
    std::size_t unseen = 0;  // pairs of steps to come
  };
  Workspace new_workspace() const;

  // Starts a search, and returns how many steps it has. The poses have to outlive it.
  std::size_t begin(const FloatBlock& block, Workspace& workspace) const;
  std::size_t begin(const SingleState& state, Workspace& workspace) const;
  // Adds the candidates of a step in some of the states. Steps are taken in their order.
  void find(std::size_t step, const FloatBlock& block, unsigned states, Workspace& workspace) const;
  void find(std::size_t step, const SingleState& state, unsigned states, Workspace& workspace) const;

 private:
  // Scenes of up to this many obstacles are tested one by one faster than by the tree (measured).
  static constexpr std::size_t kFewObstacles = 64;

  // Some pairs of movers, by the bits of their cells.
  struct MovingPairsInCells {
    std::shared_ptr<const ApartCells> cells;
    std::array<MovingPair, ApartCells::kMostPairs> pairs;
  };

  std::size_t pairs_;                 // how many
  std::vector<BoundingBall> movers_;  // around bodies that hang on links
  // The slices of mover m: slices_[first_slice_[m]] to slices_[first_slice_[m + 1] - 1].
  std::vector<BoundingBall> slices_;
  std::vector<std::size_t> first_slice_;
  std::vector<MovingPair> moving_pairs_;  // without those in cells
  std::vector<MovingPairsInCells> in_cells_;
  PlaneFilter plane_filter_;    // of movers before half-spaces
  HeightFilter height_filter_;  // and before fields of heights
  std::size_t obstacles_ = 0;
  std::vector<std::int32_t> pair_of_;                // pair_of_[mover * obstacles_ + obstacle], or −1
  std::vector<std::int32_t> movers_with_obstacles_;  // movers that have a pair with an obstacle
  std::vector<Box> world_boxes_;                     // of all obstacles, where they are few
  std::shared_ptr<const SampledPoses> sampled_;
  LazyValue<MoverGroups> mover_groups_;  // with obstacles where they are few; chosen by the first block
  std::vector<FloatBox> float_boxes_;    // of all obstacles, where they are few
  ObstacleTree tree_;
  SingleStateFilter single_state_filter_;

  std::int32_t pair_with(std::size_t mover, std::int32_t obstacle) const {
    return pair_of_[mover * obstacles_ + at(obstacle)];
  }
  void fix_radii(const PoseError* errors, FixedRadii& fixed) const;
  static void pose(const FloatBlock& block, const std::vector<BoundingBall>& balls,
                   const std::vector<float>& fixed_radii, bool are_fixed, std::vector<PosedBalls>& posed);
  unsigned near_slices(std::size_t mover, const PosedBalls& other, const Workspace& workspace) const;
  void take_near(const MovingPair& pair, unsigned states, Workspace& workspace) const;
  void find_among_movers(BlockConfigurations q, unsigned states, Workspace& workspace) const;
  void find_in_group(std::size_t index, unsigned states, Workspace& workspace) const;
  void find_near_obstacle(const MoverGroup& group, const BoxInStates& around, std::int32_t obstacle, unsigned states,
                          Workspace& workspace) const;
  void find_in_tree(std::int32_t mover, unsigned states, Workspace& workspace) const;
};

}  // namespace plannercheck
