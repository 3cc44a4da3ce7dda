// Nearest points as in gjk.hpp, in double-double: decides gaps and depths down to about 2^-92 of the bodies' reach.
#pragma once

#include "narrow_phase/gjk.hpp"

namespace plannercheck {

// `start`: an undecided answer of `nearest_points`, or just a world direction.
Proximity nearest_points_double_double(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start,
                                       PairCounters& counters);

// Narrows the bounds of a distance that doubles leave too far apart.
HullDistance hull_distance_double_double(const PosedPolytope& body_a, const PosedPolytope& body_b,
                                         const HullDistance& found, const DistanceGoal& goal, PairCounters& counters);

}  // namespace plannercheck
