// Which moving bodies are tested together against obstacles and against each other: neighbours in a chain, whose common
// box most obstacles and most other such boxes miss.
//
// In: balls around bodies on links, obstacles' boxes, pairs, links' poses in sampled states. Out: the groups that
// need the fewest tests in these states, a block at a time. Any choice gives the same verdicts; only its cost differs.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/body_slices.hpp"
#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/float_boxes.hpp"
#include "broad_phase/obstacle_tree.hpp"
#include "broad_phase/sampled_poses.hpp"
#include "broad_phase/state_block.hpp"

namespace plannercheck {

// Consecutive movers, and the obstacles with which some of them have a pair.
struct MoverGroup {
  std::size_t first, last;
  std::vector<std::int32_t> obstacles;
  std::vector<BoxLanes<StateFloats>> boxes;  // of these
  std::size_t pairs;
  bool has_partners = false;  // whether other groups' boxes are compared with its own
};

// Pairs of movers of two groups, asked where these meet; or, if `a` is `b`, everywhere.
struct PairsOfGroups {
  std::size_t a, b;
  std::vector<MovingPair> pairs;
};

struct MoverGroups {
  std::vector<MoverGroup> groups;
  std::vector<PairsOfGroups> among_movers;
};

// pair_of[mover * boxes.size() + obstacle]: −1 where there is no pair.
MoverGroups mover_groups(const std::vector<BoundingBall>& movers, const std::vector<Box>& boxes,
                         const std::vector<std::int32_t>& pair_of, const std::vector<MovingPair>& moving_pairs,
                         const SampledPoses& sampled);

}  // namespace plannercheck
