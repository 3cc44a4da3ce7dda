// Other scenes for a cell's robot: obstacles that are added, replaced, moved or removed.
//
// In: a cell, an edit. Out: a cell of its own, which shares all bodies that stay. Pairs of an obstacle that is new or
// elsewhere count as reachable unless it is far from the robot's reach: no closer proof that they never meet is made
// again, so such checks take a little longer.
#pragma once

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "library/prepared_cell.hpp"

namespace plannercheck {

// Says what is wrong with an edit, in a whole sentence.
class EditError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What becomes of an obstacle: removed; or given a pose, with the shape it has, or with points that are a hull (with a
// radius, all within it) or a cloud of balls.
struct Edit {
  enum class Kind { kRemove, kMove, kHull, kCloud };
  Kind kind;
  std::string name;
  std::array<double, 16> matrix;  // its pose, row by row
  std::vector<Vec3> points;
  double radius = 0;  // m
};

PreparedCell edited(const PreparedCell& cell, const Edit& edit);

}  // namespace plannercheck
