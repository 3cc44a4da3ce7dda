// Obstacles that a robot's bodies never meet within the joint limits, by the cells of
// plannercheck/checking/unreachable_pairs.py, which proves the idea and its margins.
//
// In: for each body some cuts, each with the place of the centre of a ball around the body in the middle of every cell,
// and the radius that covers the body's motion within a cell; then obstacles' boxes. Out: which bodies are clear of
// which obstacles in every cell of one of their cuts. This header is free of lanes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

// The ball around a body's end in the cells of a cut.
struct ReachCut {
  std::size_t centres;  // which set of centres
  double radius;        // of the ball, plus how far its centre moves within a cell, m
  double extent;        // how far from the world's origin the ball gets, m
};

struct ReachObstacle {
  Pose pose;
  Vec3 low, high;           // the box around the hull in its own frame
  double inflation_radius;  // of the hull, m
  double size;              // all lengths of the obstacle that rounding depends on, m
};

class ReachCells {
 public:
  // `centres`: sets of centres, in the order in which cells are looked at; `cuts`: the cuts of all bodies, body by
  // body; `first_cut`: where each body's cuts begin. `margin`, `relative`: how far apart counts as clear, in m and as a
  // part of all lengths.
  ReachCells(const std::vector<std::vector<Vec3>>& centres, std::vector<ReachCut> cuts,
             std::vector<std::size_t> first_cut, double margin, double relative);

  std::size_t body_count() const { return first_cut_.size() - 1; }

  bool is_clear(std::size_t body, const ReachObstacle& obstacle) const;

 private:
  // Coordinates of a set's centres, each row of whole lanes; the last centre is repeated.
  struct Centres {
    std::array<std::vector<double>, 3> along;
  };

  std::vector<Centres> centres_;
  std::vector<ReachCut> cuts_;
  std::vector<std::size_t> first_cut_;
  double margin_, relative_;

  bool is_clear(const ReachCut& cut, const ReachObstacle& obstacle) const;
};

}  // namespace plannercheck
