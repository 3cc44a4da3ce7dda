// The pairs that may come near each other on a motion: all others are apart by the bounds of speed, or by boxes.
//
// In: the first grid of a motion, bounds of the bodies' motion. Out: the pairs that the filters have to look at.
//
// By speeds: a body's points move at most at the speed that bounds them, so a pair whose bodies are further apart at
// one state than both can go from there to either end is apart throughout. Spheres around the bodies are held against
// each other and, where obstacles are many, against a tree of their boxes. What is left out keeps more than `beyond`
// away: twice the tolerance, while without this screen a pair is refused only at a state within the tolerance. So
// verdicts do not depend on it.
//
// By paths: boxes around whole paths are held against those of the obstacles, eight at a time, in floats.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/obstacle_tree.hpp"
#include "motions/motion_filters.hpp"

namespace plannercheck {

class MotionScreen {
 public:
  // `movers`: the bodies on links that are in a pair, in their order; `still`: the same for bodies that stand still.
  MotionScreen(const MotionModel& model, const std::vector<std::int32_t>& movers,
               const std::vector<std::int32_t>& still);

  struct Workspace {
    std::vector<Vec3> centres;        // of the movers, at the state that is looked at
    std::vector<std::int32_t> found;  // obstacles near one body
  };

  // Writes the pairs that may come within `beyond` of each other.
  void find_by_speeds(const MotionGrid& grid, const MotionFilters& filters, const ChainBounds& bounds, double beyond,
                      Workspace& workspace, std::vector<std::int32_t>& found) const;
  // Writes all pairs of two bodies that move, and those with obstacles whose boxes the paths meet.
  void find_by_paths(const MotionFilters& filters, std::vector<std::int32_t>& found) const;

 private:
  // A body that moves and has pairs with obstacles.
  struct Mover {
    std::int32_t body, chain;  // its chain from the world
    double radius;
    std::vector<std::int32_t> pair;  // by obstacle: the pair, or −1
    std::vector<unsigned> paired;    // the same for eight obstacles at a time: one bit each
  };

  // Two bodies that move, by their places among `moving_`.
  struct MovingPair {
    std::size_t a, b;
    std::int32_t chain_a, chain_b;
    double radii;
    std::int32_t pair;
  };

  // Boxes around eight obstacles in the world, rounded outwards: low corners, then high ones with their signs changed.
  struct Eight {
    std::array<Floats, 6> side;
  };

  std::vector<std::int32_t> unbounded_pairs_;  // with half-spaces: no box or ball is around them
  std::vector<std::int32_t> moving_;           // bodies in `moving_pairs_`
  std::vector<MovingPair> moving_pairs_;
  std::vector<Mover> movers_;
  std::vector<Eight> eights_;  // all obstacles
  ObstacleTree tree_;          // where obstacles are many

  void bound_obstacles(const MotionModel& model, const std::vector<std::int32_t>& still);
  void find_among_movers(const MotionGrid& grid, const ChainBounds& bounds, double room, Workspace& w,
                         std::vector<std::int32_t>& found) const;
  void find_near_paths(const MotionFilters& filters, std::vector<std::int32_t>& found) const;
  void find_in_tree(const MotionGrid& grid, const Mover& mover, double way, double room,
                    std::vector<std::int32_t>& found) const;
  static void take(const Mover& mover, std::size_t eight, std::uint64_t near, std::vector<std::int32_t>& found);
  static unsigned meeting(const Eight& boxes, Floats box);
};

}  // namespace plannercheck
