// How far the gap of two bodies may be off on a motion: by rounding, and by what is not of length 1 or not rigid.
//
// In: a model and a motion of it. Out: a bound for all pairs and states, in m. It adds up:
// - kinematics: the computed pose of each body is off by at most the kinematic error at the states of the grid, from
//   which the proof for exact poses follows; computed poses of states between are off the exact ones by as much again:
//   four errors;
// - rounding of the checks: of numbers up to how far any body can be from the world's origin; placements that are off
//   rigid, and with them directions and chords in links' frames;
// - parts off unit length: states go along unit quaternions, cosines and sines, while the ends are posed as given. A
//   quaternion of length 1 + ε and that of length 1 differ as matrices by at most 4ε, a circle by ε. Each such part on
//   a body's chain moves it by as much of its arm, and both bodies have up to `depth` of them;
// - configurations between the ends: their numbers err by at most 8u of the ends', which each joint turns into as much
//   of its arm.
#pragma once

#include "motions/motion_bounds.hpp"
#include "motions/motion_certifier.hpp"
#include "motions/path.hpp"

namespace plannercheck {

struct MotionRounding {
  double slack;  // the bound, m
  double size;   // of the coordinates involved, m
};

// `extent`: how far bodies extend, static ones from the world's origin, the others from their links', m. `bound`: at
// least the largest curvature and the longest arm of all chains.
MotionRounding motion_rounding(const MotionModel& model, double extent, const Path& path, const MotionBound& bound,
                               double kinematic_error);

}  // namespace plannercheck
