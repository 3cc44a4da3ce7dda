// Circles and boxes that settle intervals of a planar motion, in lanes; in doubt an interval stays open.
//
// In: a grid of states. Out: bit i is set if interval i is left open.
#pragma once

#include "planar/motion_grid_2d.hpp"

namespace plannercheck {

// Intervals on which a point within `max_distance` of the chord of a body's centre may be in a box (least x, y, largest
// x, y).
unsigned chords_meet_box(const PlanarGrid& grid, std::int32_t body, const std::array<double, 4>& box,
                         double max_distance);

// Intervals with an end at which the centres of two bodies are within `max_distance` of each other.
unsigned centres_come_near(const PlanarGrid& grid, std::int32_t a, std::int32_t b, double max_distance);

}  // namespace plannercheck
