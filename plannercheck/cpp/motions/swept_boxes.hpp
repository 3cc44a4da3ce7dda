// The boxes of a body at the states of a grid, seen from the body at one of them.
//
// In: the body's poses in lanes, its box. Out: for any run of states a box in the frame of the body at that state,
// which holds the body's box at each state of the run, and the chords between them.
#pragma once

#include <array>
#include <cstddef>

#include "motions/motion_grid.hpp"

namespace plannercheck {

struct FrameBox {
  Vec3 low, high;
};

class SweptBoxes {
 public:
  // `body`: one that moves. `box`: in its frame. The frame is that of the body at `middle`.
  SweptBoxes(MotionGrid& grid, std::int32_t body, const FrameBox& box, std::size_t middle);

  const Pose& frame() const { return frame_; }
  // Of the states from..to, with room for rounding and for poses off rigid.
  FrameBox around(std::size_t from, std::size_t to) const;

 private:
  Pose frame_;
  std::array<std::array<double, kGridRow>, 3> low_, high_;
};

}  // namespace plannercheck
