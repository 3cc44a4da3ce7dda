// How fast the distance of two points on links changes with a configuration: its gradient.
//
// In: a kinematics, the links of two bodies, the nearest points and the direction between them. Out: the derivative by
// each number of the tangent. Idea: a joint that carries one of both points turns or slides it; a joint that carries
// both keeps their distance. With n from b to a, a joint's turn about its axis w through T changes it by w · ((p − T) x
// n), and p may be either point, as they differ by a multiple of n.
//
// The tangent is Pinocchio's: a joint's angle or distance; of a planar joint its velocity along x and y of its own
// frame and its turn; of a ball its turn about x, y and z of its own frame; of a free joint both.
#pragma once

#include <cstdint>
#include <vector>

#include "math/vec.hpp"
#include "robots/kinematics.hpp"

namespace plannercheck {

class StatePoser;

// For each number of a configuration the place in the tangent of what it changes; −1 for a quaternion's last.
struct Tangent {
  std::vector<std::int32_t> places;
  std::size_t width = 0;
};

// The joints that carry one of two links and not the other.
struct CarryingJoints {
  std::vector<std::int32_t> of_a, of_b;
};
// `link_a`, `link_b`: −1 for the world.
CarryingJoints carrying_joints(const Kinematics& kinematics, std::int32_t link_a, std::int32_t link_b);

// Adds the derivatives of the distance to `gradient`, of the tangent's width. `point`: either of the nearest ones, in
// the world; `normal`: from b to a. The poser has posed the configuration.
void add_gradient(const Kinematics& kinematics, const StatePoser& posed, const CarryingJoints& joints,
                  const Tangent& tangent, Vec3 point, Vec3 normal, double* gradient);

}  // namespace plannercheck
