// Which long bodies are tested against other moving bodies as two or three slices, each in its own ball, because one
// ball around a long body meets most balls near the robot.
//
// In: bodies on links, the balls around them, their pairs, links' poses in sampled states. Out: the slices of the
// bodies for which slices leave clearly fewer pairs in these states. Any choice gives the same verdicts; only the time
// differs.
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

// The slices of one mover; none if the mover is not long, or not worth slicing.
struct BodySlices {
  std::vector<BoundingBall> balls;
  bool pay_in_blocks = false;  // also for states that are judged together
};

// By mover. `objects`: the movers.
std::vector<BodySlices> body_slices(const std::vector<const GeometryObject*>& objects,
                                    const std::vector<BoundingBall>& balls, const std::vector<MovingPair>& pairs,
                                    const SampledPoses& sampled);

}  // namespace plannercheck
