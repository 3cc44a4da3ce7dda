// The pairs that may come near each other on a motion: all others are apart by the bounds of speed, or by boxes.
//
// In: the first grid of a motion, bounds of the bodies' motion. Out: the pairs that the filters have to look at.
//
// By speeds: a bound of speed limits how far a body's points can move from one state to either end. If both bodies are
// further apart at that state than both can move, the pair is apart throughout. Spheres around the bodies are held
// against each other and, where obstacles are many, against a tree of their boxes. Pairs that this screen leaves out
// are more than `beyond` apart, twice the tolerance; a pair is refused only at a state within the tolerance. So
// verdicts do not depend on the screen.
//
// Bodies of one link come first in one sphere around all of them (the fingers of a hand, the pieces of a link), then,
// if several pairs of two links are left, in boxes along one direction.
//
// By paths: boxes around whole paths are compared with boxes of the obstacles, eight at a time, in floats; before that,
// boxes around links' paths are compared with each other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/obstacle_tree.hpp"
#include "motions/link_bounds.hpp"
#include "motions/motion_filters.hpp"

namespace plannercheck {

class MotionScreen {
 public:
  // `movers`: the bodies on links that are in a pair, in their order; `still`: the same for bodies that stand still.
  MotionScreen(const MotionModel& model, const std::vector<std::int32_t>& movers,
               const std::vector<std::int32_t>& still);

  struct Workspace {
    std::vector<Lanes> rows;          // of the balls' centres, as MotionGrid has them
    std::vector<Floats> paths;        // by ball, as `box_around_path`; infinite where no chain from the world is known
    std::vector<std::size_t> near;    // links that may come near each other
    std::vector<Vec3> directions;     // of links with several pairs: the direction that kept them apart last
    std::vector<std::int32_t> found;  // obstacles near one ball
  };

  // Writes the pairs that may come within `beyond` of each other.
  void find_by_speeds(const MotionGrid& grid, const MotionFilters& filters, const ChainBounds& bounds, double beyond,
                      Workspace& workspace, std::vector<std::int32_t>& found) const;
  // Writes all pairs of two bodies that move, and those with obstacles whose boxes the paths meet.
  void find_by_paths(const MotionFilters& filters, std::vector<std::int32_t>& found) const;

 private:
  // Some of `chains_`.
  struct ChainRange {
    std::size_t first, past;
  };

  // A body that moves and has pairs with obstacles.
  struct Mover {
    std::int32_t body, chain;        // its chain from the world
    std::vector<std::int32_t> pair;  // by obstacle: the pair, or −1
    std::vector<unsigned> paired;    // the same for eight obstacles at a time: one bit each
  };

  // The movers on one link, and a ball around all bodies of the link.
  struct LinkMovers {
    std::size_t ball;
    ChainRange chains;  // from the world, of all bodies of the link that are seen from there
    std::vector<Mover> movers;
    std::vector<unsigned> paired;  // obstacles with which any of them has a pair
  };

  // The pairs of two links that are seen from one frame: a range of `moving_pairs_`.
  struct MovingGroup {
    std::size_t a, b;  // balls
    std::int32_t frame;
    ChainRange chains_a, chains_b;
    double radii;
    std::size_t first_pair, past_pairs;
  };

  // Boxes around eight obstacles in the world, rounded outwards: low corners, then high ones with their signs changed.
  struct Eight {
    std::array<Floats, 6> side;
  };

  std::vector<std::int32_t> unbounded_pairs_;  // with half-spaces: no box or ball is around them
  std::vector<LinkBound> balls_;
  std::vector<std::int32_t> chains_;
  std::vector<std::int32_t> moving_pairs_;  // of two bodies that move
  std::vector<MovingGroup> moving_groups_;
  std::size_t from_world_ = 0;  // so many of them, the first ones, are seen from the world
  std::vector<LinkMovers> movers_by_link_;
  std::vector<Eight> eights_;  // all obstacles
  ObstacleTree tree_;          // where obstacles are many

  void group_movers(const MotionModel& model, std::vector<Mover> movers, const std::vector<std::size_t>& ball_of);
  void group_pairs(const MotionModel& model, const std::vector<std::size_t>& ball_of);
  ChainRange chains(const MotionModel& model, std::vector<std::int32_t> of_bodies);
  void bound_obstacles(const MotionModel& model, const std::vector<std::int32_t>& still);

  double speed(const ChainBounds& bounds, ChainRange chains) const;
  double shift(const ChainBounds& bounds, ChainRange chains) const;
  double curvature(const ChainBounds& bounds, ChainRange chains) const;
  double shift_from_obstacles(const ChainBounds& bounds, ChainRange chains) const;
  static const double* rows(const Workspace& w, std::size_t ball);
  void pose_balls(const MotionGrid& grid, Workspace& w) const;
  Floats box_around_path(const MotionFilters& filters, const ChainBounds& bounds, double beyond, const Workspace& w,
                         const LinkMovers& group) const;
  std::size_t find_meeting_paths(double beyond, Workspace& w) const;
  template <bool are_all>
  std::size_t find_near_balls(const MotionGrid& grid, const ChainBounds& bounds, double room, std::size_t groups,
                              Workspace& w) const;
  void bound_paths(const MotionFilters& filters, const ChainBounds& bounds, double beyond, Workspace& w) const;
  void find_among_links(const MotionGrid& grid, const MotionFilters& filters, const ChainBounds& bounds, double beyond,
                        Workspace& w, std::vector<std::int32_t>& found) const;
  bool boxes_stay_apart(const MovingGroup& group, const MotionGrid& grid, const MotionFilters& filters,
                        const ChainBounds& bounds, double beyond, Vec3& direction) const;
  void find_near_links(const MotionFilters& filters, const ChainBounds& bounds, double beyond, const Workspace& w,
                       std::vector<std::int32_t>& found) const;
  void find_in_tree(const MotionGrid& grid, const LinkMovers& group, double way, double room, Workspace& w) const;
  std::uint64_t near_boxes(std::size_t first, Floats box, const std::vector<unsigned>& paired) const;
  static void take(const Mover& mover, std::size_t eight, std::uint64_t near, std::vector<std::int32_t>& found);
  static unsigned meeting(const Eight& boxes, Floats box);
};

}  // namespace plannercheck
