// Which moving bodies are tested together against obstacles: neighbours in a chain, whose common box most obstacles
// miss.
//
// In: balls around bodies on links, obstacles' boxes, pairs, links' poses in sampled states. Out: the groups that
// need the fewest tests in these states, a block at a time. Any choice gives the same verdicts; only its cost differs.
#pragma once

#include <cstdint>
#include <vector>

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
};

// pair_of[mover * boxes.size() + obstacle]: −1 where there is no pair.
std::vector<MoverGroup> mover_groups(const std::vector<BoundingBall>& movers, const std::vector<WorldBox>& boxes,
                                     const std::vector<std::int32_t>& pair_of, const SampledPoses& sampled);

}  // namespace plannercheck
