// Which pairs of bodies may touch, for eight states at once: bounding balls among moving bodies, and a tree over the
// obstacles.
//
// In: posed links of a block of states, in lanes. Out: for each state the pairs that no bound settles. Every bound is
// proved with its rounding, so that none of these filters can change a verdict. Immutable; what it finds and the balls
// it poses are the caller's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mounted_body.hpp"
#include "obstacle_tree.hpp"
#include "simd.hpp"

namespace plannercheck {

inline constexpr int kBlockStates = kFloats;                // states judged together: one a float lane
inline constexpr int kBlockGroups = kBlockStates / kLanes;  // of Lanes that hold a number of each of them
static_assert(kBlockGroups * kLanes == kBlockStates);

// Link poses of a block: number i of the row-major 3x4 matrix of a link, for the states of a group.
inline std::size_t pose_index(std::size_t links, std::size_t group, std::size_t link) {
  return (group * links + link) * 12;
}

class BroadPhase {
 public:
  BroadPhase(const std::vector<MountedBody>& bodies, const std::vector<std::array<std::int32_t, 2>>& pairs,
             std::size_t links);

  // A ball around a moving body in each state of a block; its radius covers the rounding of its posing.
  struct Balls {
    std::array<float, kBlockStates> x, y, z, radius;
  };

  struct Workspace {
    std::vector<Balls> balls;
    std::vector<std::int32_t> obstacles;
    std::array<std::vector<std::int32_t>, kBlockStates> near;  // pairs, by state
  };
  Workspace new_workspace() const;

  // Fills `near` for the first `count` states.
  void find(const Lanes* links, int count, Workspace& workspace) const;
  // The same without any bound: all pairs.
  void take_all(int count, Workspace& workspace) const;

 private:
  // A body that hangs on a link: a ball around it, in the link's frame.
  struct Mover {
    std::int32_t link;
    Vec3 centre;
    double radius;
    double reach;  // how far numbers get that go into posing the ball, at most: for their rounding
  };

  struct MovingPair {
    std::int32_t a, b;  // movers
    std::int32_t pair;
  };

  std::size_t links_, pairs_;
  std::vector<Mover> movers_;
  std::vector<MovingPair> moving_pairs_;
  std::vector<std::int32_t> fixed_pairs_;  // of two bodies that are fixed to the world
  std::size_t obstacles_;
  std::vector<std::int32_t> pair_of_;  // pair_of_[mover * obstacles_ + obstacle], or −1
  std::vector<std::int32_t> hunters_;  // movers that have a pair with an obstacle
  ObstacleTree tree_;

  void pose_balls(const Lanes* links, std::size_t group, Workspace& workspace) const;
  void find_among_movers(int count, Workspace& workspace) const;
  void find_obstacles(int count, Workspace& workspace) const;
};

}  // namespace plannercheck
