// How far the points of a body may leave the chords of their paths, and how far they travel: from rates of joints and
// lever arms.
//
// In: chains of joints from a frame to a body with each joint's arm (plannercheck/motion_chains.py), a motion. Out: for
// each chain a bound of |p''| and of |p'| over all points p of the body, seen from the frame, for a parameter that goes
// from 0 to 1.
//
// Proof. With the joints 1 … k of the chain counted from the frame, p(t) = P1 exp(t ξ1) P2 exp(t ξ2) … p for constant
// placements P and twists ξ = (v, ω). A derivative puts a factor ξ before an exponential: applied to a point y it gives
// the velocity ω×y + v, of length at most s = |ω| R + |v|, if R bounds the distance of the body's points from the
// joint's axis (from its origin, if it has none); applied to a velocity w it gives ω×w; the other factors only rotate.
// So |p'| <= Σ s_j, and, each pair of different joints occurring twice, |p''| <= Σ_j s_j (|ω_j| + 2 Σ_{i<j} |ω_i|).
//
// A point on the path between parameters a and b is no further than (b − a)² / 8 max |p''| from the point of the chord
// at the same parameter (the error of linear interpolation, along any direction and thus in length).
#pragma once

#include "configuration_path.hpp"

namespace plannercheck {

// Where a joint's rate comes from.
enum class DriveKind : int { kTurn, kSlide, kPart };

struct JointDrive {
  DriveKind kind;
  std::int32_t column;
  double multiplier, offset;  // of turns and slides
};

struct ChainEntry {
  std::int32_t joint;
  double arm;                             // R above, but for what joints between this one and the body slide, m
  std::int32_t first_slide, past_slides;  // those joints, in MotionChains::slides
};

struct MotionChains {
  std::vector<JointDrive> joints;
  std::vector<ChainEntry> entries;
  std::vector<std::int32_t> slides;
  std::vector<std::int32_t> first_entry;  // per chain, and one past the last
};

struct MotionBound {
  double curvature = 0, speed = 0, arm = 0;  // |p''|, |p'|, the longest R; m
};

// Rates of all joints for a motion.
void rates_of(const MotionChains& chains, const ConfigurationPath& path, std::vector<Rate>& rates);

MotionBound bound_of(const MotionChains& chains, std::size_t chain, const std::vector<Rate>& rates);

}  // namespace plannercheck
