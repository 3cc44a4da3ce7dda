// How far a body's points may travel, and leave the chords of their paths, from joint rates and lever arms.
//
// In: chains of joints from a frame to a body with each joint's arm (plannercheck/motions/joint_chains.py); a motion.
// Out: for each chain a bound of |p''| and of |p'| over all points p of the body, seen from the frame, as the parameter
// goes from 0 to 1.
//
// Proof. Count the chain's joints 1 … k from the frame to the body. Each moves along a constant twist ξ = (v, ω), given
// in the frame of the link after it, its child: the child's pose in the joint's placement is X(t) = X(0) exp(t ξ). A
// chain that crosses the joint from its parent to its child has the factor X(t). A chain that crosses it the other way,
// because the frame hangs on the joint, has X(t)⁻¹ = exp(−t ξ) X(0)⁻¹. So p(t) = P1 exp(±t ξ1) P2 exp(±t ξ2) … p for
// constant rigid maps P. In both cases exp(±t ξ) involves points in the child's frame: its arguments in the first case,
// its values in the second. As ξ commutes with exp(±t ξ), the derivative is ±ξ applied to these points.
//
// Applied to a point y, ξ gives the velocity ω×y + v. Its length is at most s = |ω| R + |v|, if R bounds the distance
// of the body's points, in the child's frame, from the joint's axis, or from the child's origin if there is no axis.
// Applied to a velocity w, ξ gives ω×w; the other factors only rotate. So |p'| <= Σ s_j and, as each pair of different
// joints occurs twice, |p''| <= Σ_j s_j (|ω_j| + 2 Σ_{i<j} |ω_i|).
//
// R at any configuration on the motion: a joint that only turns has the same axis or origin on both its links. For a
// joint that slides, the origins on both links are |x| apart, x being its position, and |x| <= extent all the way. So R
// is the length along the chain at x = 0, plus the extent of each sliding joint both of whose links lie on the way from
// the body to the child of the joint in question. This includes the joint's own extent if the chain crosses it from
// child to parent: the child is then the far side, and a turn of a planar or floating joint at x swings everything that
// does not hang on it about a point |x| further off. (Irrelevant if the joint only slides: s is |v|.)
//
// Extents: along a screw the origin's velocity is R(t) v, of constant length |v|, so |x(t)| <= |x(0)| + t |v|. A
// prismatic joint's value (even if it mimics another one) is largest at an end or, of a curve, at a control point.
//
// The distance of a point on the path between parameters a and b from the point of the chord at the same parameter is
// at most (b − a)² / 8 max |p''| (the error of linear interpolation, along any direction and thus in length).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "math/vec.hpp"
#include "motions/path.hpp"

namespace plannercheck {

// Where a joint's rate comes from.
enum class DriveKind : int { kTurn, kSlide, kPart };

struct JointDrive {
  DriveKind kind;
  std::int32_t column;
  double multiplier, offset;  // of turns and slides
};

struct ChainJoint {
  std::int32_t joint;
  double arm;                             // R above without extents, m
  std::int32_t first_slide, past_slides;  // the joints whose extents it includes, in MotionChains::slides
};

struct MotionChains {
  std::vector<JointDrive> joints;
  std::vector<ChainJoint> entries;
  std::vector<std::int32_t> slides;
  std::vector<std::int32_t> first_entry;  // per chain, and one past the last
};

// Bounds of how fast a joint's rate changes on a curve.
struct RateChange {
  double turn = 0, slide = 0;
};
// The rates of all joints on a motion. `changes`: empty on a straight motion.
struct Rates {
  std::vector<Rate> joints;
  std::vector<RateChange> changes;

  bool is_curve() const { return !changes.empty(); }
};

struct MotionBound {
  double curvature = 0, speed = 0, arm = 0;  // |p''|, |p'|, the longest R; m
};

// How far points may be off the chords of their paths: by |p''|, and by a tube, m.
struct Deviation {
  double curvature = 0, shift = 0;
};

inline Deviation operator+(Deviation a, Deviation b) { return {a.curvature + b.curvature, a.shift + b.shift}; }

// The bounds of all chains for one motion. Chain −1 belongs to what stands still: its bounds are 0.
class ChainBounds {
 public:
  double curvature(std::int32_t chain) const { return curvature_[at(chain + 1)]; }
  // How far a tube shifts points, plus half the distance that bodies have to stay apart.
  double shift(std::int32_t chain) const { return tube_ != nullptr ? tube_->speed(chain) : 0; }
  // For a chain from the world: the obstacles' half of the distance included.
  double shift_from_obstacles(std::int32_t chain) const { return has_tube() ? shift(chain) + shift(-1) : 0; }
  Deviation deviation(std::int32_t chain) const { return {curvature(chain), shift(chain)}; }
  // The bounds of a tube, which has to outlive this; null for none.
  void set_tube(const ChainBounds* tube) { tube_ = tube; }
  bool has_tube() const { return tube_ != nullptr; }
  double speed(std::int32_t chain) const { return speed_[at(chain + 1)]; }
  // The largest of each, over all chains.
  const MotionBound& largest() const { return largest_; }

 private:
  friend class ChainTable;

  std::vector<double> curvature_, speed_;
  MotionBound largest_;
  const ChainBounds* tube_ = nullptr;
};

// The chains in another order: neighbours have most joints in common, and those whose arms depend on the motion are
// last. Writes where each chain has gone.
MotionChains sorted_chains(const MotionChains& chains, std::vector<std::int32_t>& place);

// The chains, arranged so that as many as there are lanes are bounded at once.
class ChainTable {
 public:
  // `chains`: sorted.
  explicit ChainTable(const MotionChains& chains);

  // Each bound has the bits of `bound_of`.
  void bound(const MotionChains& chains, const Rates& rates, ChainBounds& bounds) const;
  // How far a tube shifts points, given its rates; `room`: how far bodies have to stay apart.
  void bound_tube(const MotionChains& chains, const Rates& rates, double room, ChainBounds& tube) const;
  // Upper bounds of the largest bounds of all chains, by sums over all joints: far from tight, but fast.
  MotionBound at_most(const Rates& rates) const;

 private:
  // Neighbouring chains, one in each lane, and one joint in each row, which chains without it pass over.
  struct Group {
    std::size_t first_row, past_rows;
  };

  std::vector<Group> groups_;
  std::vector<std::size_t> joints_;         // by row
  std::vector<double> arms_;                // by row and lane
  std::vector<std::int64_t> on_chain_;      // the same: all bits or none
  double longest_arm_ = 0;                  // of the chains in groups
  double longest_entry_ = 0;                // of all chains, without extents
  std::size_t in_groups_ = 0, chains_ = 0;  // the others' arms depend on the motion

  void add_group(const MotionChains& chains, std::size_t first, std::size_t past);
  template <bool is_curve>
  void bound_rows(const MotionChains& chains, const Rates& rates, ChainBounds& bounds) const;
};

// The rates of all joints for a motion.
void rates_of(const MotionChains& chains, const Path& path, Rates& rates);
// The rates of going from the path to an end of its tube.
void tube_rates_of(const MotionChains& chains, const Path& path, Rates& rates);

MotionBound bound_of(const MotionChains& chains, std::size_t chain, const Rates& rates);

}  // namespace plannercheck
