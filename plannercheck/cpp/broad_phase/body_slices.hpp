// Which long bodies are tested against other moving bodies as two or three slices, each in a ball of its own, since one
// ball around all of such a body meets most of what is near the robot.
//
// In: bodies on links, the balls around them, their pairs, links' poses in sampled states. Out: the slices of those for
// which they leave enough pairs fewer in these states. Any choice gives the same verdicts; only its cost differs.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/sampled_poses.hpp"

namespace plannercheck {

// A pair of two movers.
struct MovingPair {
  std::int32_t a, b;
  std::int32_t pair;
};

// Those of one mover; none if it is not long, or not worth slicing.
struct BodySlices {
  std::vector<BoundingBall> balls;
  bool pay_in_blocks = false;  // also for states that are judged together
};

// By mover. `objects`: the movers.
std::vector<BodySlices> body_slices(const std::vector<const GeometryObject*>& objects,
                                    const std::vector<BoundingBall>& balls, const std::vector<MovingPair>& pairs,
                                    const SampledPoses& sampled);

}  // namespace plannercheck
