// How far the points of a body may leave the chords of their paths, and how far they travel: from rates of joints and
// lever arms.
//
// In: chains of joints from a frame to a body with each joint's arm (plannercheck/motions/joint_chains.py), a motion.
// Out: for each chain a bound of |p''| and of |p'| over all points p of the body, seen from the frame, for a parameter
// that goes from 0 to 1.
//
// Proof. Count the chain's joints 1 … k from the frame to the body. Each moves along a constant twist ξ = (v, ω), given
// in the frame of the link after it, its child: the child's pose in the joint's placement is X(t) = X(0) exp(t ξ). A
// chain that crosses the joint from its parent to its child has the factor X(t); one that crosses it the other way,
// since the frame hangs on the joint, has X(t)⁻¹ = exp(−t ξ) X(0)⁻¹. Either way p(t) = P1 exp(±t ξ1) P2 exp(±t ξ2) … p
// for constant rigid maps P, and either way exp(±t ξ) takes points as the child's link has them: those it is applied to
// in the first case, those it yields in the second, and as ξ commutes with exp(±t ξ), the derivative is ±ξ applied to
// them.
//
// Applied to a point y, ξ gives the velocity ω×y + v, of length at most s = |ω| R + |v|, if R bounds the distance of
// the body's points, as the child's link has them, from the joint's axis, or, if it has none, from the child's origin.
// Applied to a velocity w it gives ω×w; the other factors only rotate. So |p'| <= Σ s_j, and, each pair of different
// joints occurring twice, |p''| <= Σ_j s_j (|ω_j| + 2 Σ_{i<j} |ω_i|).
//
// R at any configuration on the motion: a joint's axis or origin is the same on both its links if it only turns. Of a
// joint that slides, the origins on both links are |x| apart, x being its position, and |x| <= extent all the way. So R
// is the length along the chain at x = 0, and for each sliding joint whose both links the way from the body to the
// child of the joint at hand touches, its extent. That includes the joint's own if the chain crosses it from child to
// parent: the child is then the far side, and a turn of a planar or floating joint at x swings all that does not hang
// on it about a point |x| further off. (It does not matter for joints that slide and do not turn: s is |v|.)
//
// Extents: along a screw the origin's velocity is R(t) v, of constant length |v|, so |x(t)| <= |x(0)| + t |v|. A
// prismatic joint's value is linear in t (also that of one that follows another), so |x| is largest at an end.
//
// A point on the path between parameters a and b is no further than (b − a)² / 8 max |p''| from the point of the chord
// at the same parameter (the error of linear interpolation, along any direction and thus in length).
#pragma once

#include "motions/configuration_path.hpp"

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
  double arm;                             // R above but for extents, m
  std::int32_t first_slide, past_slides;  // the joints whose extents belong to it, in MotionChains::slides
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
