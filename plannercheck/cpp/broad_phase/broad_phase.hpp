// Which pairs of bodies may touch, for a block of states at once. Bounding balls are tested among moving bodies, and
// against obstacles' boxes, in a tree where these are many. Of the pairs left, balls and boxes inside bodies prove
// collisions, and boxes around bodies prove others apart.
//
// In: posed links of a block of states, in lanes. Out: the states that surely collide, if only that counts, and for
// every other state the pairs that no bound decides. Every bound is proved with its rounding, so no filter changes a
// verdict. Immutable; the workspace for results and posed balls is the caller's.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "bodies/lazy_value.hpp"
#include "broad_phase/apart_cells.hpp"
#include "broad_phase/block_configurations.hpp"
#include "broad_phase/body_slices.hpp"
#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/box_filter.hpp"
#include "broad_phase/float_boxes.hpp"
#include "broad_phase/float_link_poses.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/height_filter.hpp"
#include "broad_phase/likely_overlaps.hpp"
#include "broad_phase/mover_groups.hpp"
#include "broad_phase/obstacle_tree.hpp"
#include "broad_phase/overlap_filter.hpp"
#include "broad_phase/plane_filter.hpp"
#include "broad_phase/single_state_filter.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class BroadPhase {
 public:
  // `permanent`: for each pair, whether both bodies stand still and share a point. Other such pairs are apart.
  // `in_cells`: pairs of moving bodies that are looked up by the configuration first.
  BroadPhase(const std::vector<GeometryObject>& bodies, const std::vector<std::array<std::int32_t, 2>>& pairs,
             const std::vector<bool>& permanent, std::size_t links, std::shared_ptr<const SampledPoses> sampled,
             const std::vector<PairsInCells>& in_cells);

  // A ball around a moving body in each state of a block; its radius covers the rounding of its posing.
  struct Balls {
    StateFloats x, y, z, radius;
  };

  // A pair and the states in which it may touch, one bit each.
  struct Candidate {
    std::int32_t pair;
    unsigned states;
  };

  // Of balls whose radii are the same in all states: radii of movers and slices, and what squared distances have to
  // exceed, from obstacles by mover and among movers by pair.
  struct FixedRadii {
    std::uint64_t posed_by = 0;  // the kinematics; 0 if they are none's
    std::vector<float> movers, slices, from_obstacles, of_pairs;
  };

  struct Workspace {
    FloatLinkPoses links;
    std::vector<PoseColumns> state_links;  // of one state of a block that has few
    std::vector<Balls> balls, slices;
    FixedRadii fixed;
    bool are_fixed = false;  // in this block
    SingleStateFilter::Workspace single_state_filter;
    BlockBoxes::Workspace boxes;
    BlockOverlaps::Workspace overlaps;
    std::vector<Candidate> candidates;
    std::size_t tested = 0;                    // so many candidates have been looked at for overlaps
    std::vector<Candidate> unboxed;            // the same with half-spaces and fields of heights
    std::vector<std::int32_t> found, reached;  // obstacles near the ball: in one state, in any state
    std::vector<unsigned> states;              // per obstacle, those in which it is near; 0 between searches
    std::array<std::vector<std::int32_t>, kBlockStates> near;  // pairs, by state
    // What `near` says as well; to look at all its lists would take some per cent of a state.
    unsigned undecided = 0;                       // states in which a pair is near, a bit each: other lists are empty
    long near_pairs = 0;                          // of all states
    bool boxed = false;                           // whether boxes have been tested
    long boxes_apart = 0;                         // pairs that the boxes separate
    unsigned overlapping = 0;                     // states in which some pair surely shares a point
    std::size_t overlap = LikelyOverlaps::kNone;  // the pair that was found to do so last
    LikelyOverlaps likely;                        // of single states
    // The pair that was found to do so in the last state of a block, if one was: along motions, the next states mostly
    // collide alike.
    std::size_t overlap_at_end = LikelyOverlaps::kNone;
    std::size_t likeliest_group = 0;  // of movers, in which an overlap was found last
    long skipped = 0;                 // other pairs of these states
  };
  Workspace new_workspace() const;

  // Filters for pairs whose balls meet.
  struct Filters {
    bool overlaps;  // finds states that surely collide, whose other pairs are then skipped
    bool boxes;     // used only where there are enough states for it to pay
    bool learning;  // with overlaps: pairs that overlapped lately are tried first
  };

  // Fills `near` for the first `count` states, whose configurations may be unknown.
  void find(const Lanes* links, BlockConfigurations q, int count, Filters filters, Workspace& workspace) const;
  // The same for poses in floats, with their errors by link; `posed_by`: the kinematics whose errors these always are,
  // or 0.
  void find(const FloatPose* links, const PoseError* errors, std::uint64_t posed_by, BlockConfigurations q, int count,
            Filters filters, Workspace& workspace) const;
  // The same for one state.
  void find(const PoseColumns* links, const double* q, Filters filters, Workspace& workspace) const;
  // The same without bounds: all pairs.
  void take_all(int count, Workspace& workspace) const;
  // Empties `near`, for callers that fill it themselves.
  static void clear_near(Workspace& workspace);

 private:
  // Scenes of up to this many obstacles are tested one by one faster than by the tree (measured).
  static constexpr std::size_t kFewObstacles = 64;

  // Some pairs of movers, by the bits of their cells.
  struct MovingPairsInCells {
    std::shared_ptr<const ApartCells> cells;
    std::array<MovingPair, ApartCells::kMostPairs> pairs;
  };

  // A box in every lane.
  struct BoxInFloats {
    std::array<StateFloats, 3> low, high;

    unsigned met(const BoxLanes<StateFloats>& boxes) const;  // the boxes that it meets, a bit each
  };

  // A box in each state, around some movers.
  struct BoxInStates {
    std::array<StateFloats, 3> low, high;

    unsigned met(const FloatBox& box) const;  // the states in which it meets the box, a bit each
    BoxInFloats around_all() const;
  };

  std::size_t links_;
  std::vector<std::array<std::int32_t, 2>> pairs_;
  std::vector<BoundingBall> movers_;  // around bodies that hang on links
  // Of movers that are tested against others as slices: slices_[first_slice_[m]] to slices_[first_slice_[m + 1] - 1].
  std::vector<BoundingBall> slices_;
  std::vector<std::size_t> first_slice_;
  std::vector<MovingPair> moving_pairs_;  // without those in cells
  std::vector<MovingPairsInCells> in_cells_;
  std::vector<std::int32_t> permanent_pairs_;  // these collide in every state
  PlaneFilter plane_filter_;                   // of movers before half-spaces
  HeightFilter height_filter_;                 // and before fields of heights
  std::size_t obstacles_;
  std::vector<std::int32_t> pair_of_;                // pair_of_[mover * obstacles_ + obstacle], or −1
  std::vector<std::int32_t> movers_with_obstacles_;  // movers that have a pair with an obstacle
  std::vector<WorldBox> world_boxes_;                // of all obstacles, where they are few
  std::shared_ptr<const SampledPoses> sampled_;
  LazyValue<std::vector<MoverGroup>> mover_groups_;  // where obstacles are few; chosen when a block first needs them
  std::vector<FloatBox> float_boxes_;                // of all obstacles, where they are few
  ObstacleTree tree_;
  SingleStateFilter single_state_filter_;
  BlockBoxes boxes_;
  BlockOverlaps overlaps_;

  std::int32_t pair_with(std::size_t mover, std::int32_t obstacle) const {
    return pair_of_[mover * obstacles_ + at(obstacle)];
  }
  BoxInStates around(const MoverGroup& group, const std::vector<Balls>& balls) const;
  static void begin(Workspace& workspace);
  void take_overlapping(int count, Workspace& workspace) const;
  void find_for_block(BlockConfigurations q, int count, Filters filters, Workspace& workspace) const;
  void find_in_groups(int count, Filters filters, Workspace& workspace) const;
  template <class Value>
  void find_for_state(const PoseColumns* links, Value value, std::size_t state, Workspace& workspace) const;
  const PoseColumns* links_in_state(const Lanes* links, std::size_t state, Workspace& workspace) const;
  void filter(int count, Filters filters, Workspace& workspace) const;
  void fix_radii(const PoseError* errors, FixedRadii& fixed) const;
  static void pose(const std::vector<BoundingBall>& balls, const std::vector<float>& fixed_radii,
                   std::vector<Balls>& posed, Workspace& workspace);
  static unsigned near(const Balls& a, const Balls& b) { return near(a, b, far_beyond(a.radius + b.radius)); }
  static unsigned near(const Balls& a, const Balls& b, StateFloats limit);
  unsigned near_slices(std::size_t mover, const Balls& other, const Workspace& workspace) const;
  void take_near(const MovingPair& pair, unsigned states, Workspace& workspace) const;
  void find_among_movers(BlockConfigurations q, unsigned states, Workspace& workspace) const;
  void find_listed(const MoverGroup& group, unsigned states, Workspace& workspace) const;
  void find_near_obstacle(const MoverGroup& group, const BoxInStates& around, std::int32_t obstacle, unsigned states,
                          Workspace& workspace) const;
  void find_in_tree(std::int32_t mover, unsigned states, Workspace& workspace) const;
  static void drop(Candidate& candidate, unsigned apart, Workspace& workspace);
  unsigned drop_apart(Candidate& candidate, unsigned states, Workspace& workspace) const;
  void drop_apart_at_edges(Candidate& candidate, Workspace& workspace) const;
  static void take_overlap(std::size_t pair, unsigned states, int count, Workspace& workspace);
  bool find_overlaps(int count, std::size_t unseen, Workspace& workspace) const;
  static void drop_overlapping(Workspace& workspace);
  unsigned overlap(std::size_t pair, Workspace& workspace) const;
};

}  // namespace plannercheck
