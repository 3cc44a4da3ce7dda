// Chunks of waypoints, each with a stop behind it, judged by few motions: what a gate asks of most chunks.
//
// In: where the robot stands, its waypoints at even times, straight between them, limits, decelerations, a tube. Out:
// whether the chunk passes for sure, or fails for sure. Where nothing is known, or all but the stop, the plain path of
// the gate judges (plannercheck/validation/gates).
//
// Idea. The chunk is a chain of straight pieces, and so is the stop, but for how far joints are off them. One straight
// motion covers several pieces, with a tube as wide as they are off it: their difference from it is linear in each
// piece, so it is largest at an end. What such a cover leaves open is cut in halves, down to single pieces, of which
// the tube is the gate's own. Bodies keep more than the tolerance apart on a cover, so that the plain path, which may
// refuse what comes nearer, passes all that passes here.
//
// In a stop, joint j gets by d = v T / 2 further, of which the part 1 − (1 − t/T)² is done at t. The pieces of the stop
// are straight by the part that is left of the joint that takes longest, w = (1 − t/M)². With r = T/M and x = √w, what
// joint j has left is h², h = (x − (1 − r)) / r, or 0 once it rests. This is convex in w, so between two instants the
// joint is ahead of the straight piece, by most where h / (r x) is the slope of that: at x = (1 − r) / (1 − r² slope).
// T is less than 2 ns longer than |v|/brake (stops.py), by which the states of a stop change by less than 1 ns · |v|.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "motions/motion_report.hpp"
#include "motions/path.hpp"

namespace plannercheck {

// A gate's limits and tolerances, by joint, rad and m.
struct GateNumbers {
  std::vector<double> lower, upper, velocity, acceleration, brake;
  std::vector<double> tube;  // of every motion, rounding included; its last number is how far bodies have to stay apart
  double tolerance;          // motions on which bodies are nearer than that distance plus this may be refused, m
};

// The steps between waypoints, s.
struct ChunkSteps {
  double first, last, least;
};

enum class ChunkAnswer : int { kFails, kPasses, kPassesButTheStop, kUnknown };

// Judges a straight motion; kImprecise if it stays open.
using MotionJudge = std::function<MotionAnswer(const Segment& motion)>;

// `rows`: the robot's configuration and n waypoints; `dq`: its velocities.
ChunkAnswer judged_chunk(const GateNumbers& numbers, const double* rows, std::size_t n, const double* dq,
                         const ChunkSteps& steps, const MotionJudge& judge);

}  // namespace plannercheck
