// Which moving bodies are tested together against obstacles: neighbours in a chain, which a box around all of them
// keeps apart from most obstacles at once.
//
// In: balls around bodies on links, obstacles' boxes, pairs, links' poses in some states. Out: companies, chosen so
// that in those states, eight at a time, there is least to test. Any choice is right; it only costs more or less.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/obstacle_tree.hpp"
#include "broad_phase/sampled_poses.hpp"

namespace plannercheck {

// Movers that follow one another, and the obstacles that some of them have a pair with.
struct Company {
  std::size_t first, last;
  std::vector<std::int32_t> obstacles;
};

// pair_of[mover * boxes.size() + obstacle]: −1 where there is no pair.
std::vector<Company> companies(const std::vector<BoundingBall>& movers, const std::vector<WorldBox>& boxes,
                               const std::vector<std::int32_t>& pair_of, const SampledPoses& sampled);

}  // namespace plannercheck
