// Motions that are proved free, not sampled: the straight segment between two configurations, every joint on its way.
//
// In: posed bodies on links, pairs of them, chains of joints with lever arms (motion_bounds), a motion. Out: whether it
// is free; or up to which parameter it is proved free, and where and why it is not.
//
// Idea. The motion is cut into intervals. Seen from a frame between the two bodies of a pair, a point's path leaves its
// chord over an interval of length h by at most h²/8 times a bound of |p''|. Along a direction n fixed in that frame
// the gap of the bodies is therefore at least that of the ends, interpolated, less ε = h²/8 (the sum of both bodies'
// bounds). So if some n keeps the bodies more than ε apart at both ends, then they are apart all the way. Such an n is
// sought cheapest first, one state a lane: boxes around whole paths, bounding spheres on chords against boxes, boxes
// along the plane that separated the pair last time, hulls along it, and at last by swept_distance. Pairs that have
// none for some interval go on there, cut finer. Since ε shrinks with h², a clearance c needs h of about √c.
//
// A motion is refused only where, at a state on it, a pair is proved to be within `tolerance` (touching included).
//
// Immutable: each thread brings a workspace. Of what it holds only planes outlive a motion, as hints: they may settle a
// pair that the motion's own planes settle in any case, so verdicts do not depend on what was asked before.
#pragma once

#include <memory>

#include "checking/checker.hpp"
#include "motions/configuration_path.hpp"
#include "motions/motion_bounds.hpp"
#include "motions/motion_report.hpp"

namespace plannercheck {

// Two bodies, of which the first one moves. Frame: the link whose rotation is that of the frame, −1 for the world.
// Chains: from the frame to each body, −1 where the body stands still in it.
struct CertifiedPair {
  std::int32_t a, b, frame, chain_a, chain_b;
};

struct MotionModel {
  std::vector<MountedBody> bodies;  // link −1: stands still at its placement
  std::vector<CertifiedPair> pairs;
  MotionChains chains;
  std::vector<PathPart> parts;
  std::int32_t width = 0, links = 0;
  double defect = 0;    // sum over all placements, axes and held joints of how far they are off rigid
  double leverage = 1;  // sum of the multipliers' sizes: how much all joints turn for one unit of all columns
  double depth = 0;     // most parts (circles, quaternions) on one chain from the world
  // How far joints and links may be from the world's origin: with all columns at 0, and for each unit of a column, m.
  double extent = 0;
  std::vector<double> travel;
  double joints = 0;  // on the longest chain
};

using MotionProof = IntervalProof<Vec3>;

struct MotionCounters : GridCounters {
  PairCounters pair;
};

inline MotionCounters& operator+=(MotionCounters& sum, const MotionCounters& more) {
  static_cast<GridCounters&>(sum) += more;
  sum.pair += more.pair;
  return sum;
}

class MotionCertifier {
 public:
  // `hints`: whether planes of earlier motions are tried.
  explicit MotionCertifier(MotionModel model, bool hints);

  struct Workspace;  // hidden, since it holds lanes
  std::shared_ptr<Workspace> new_workspace() const;
  // What has been counted since the last call.
  static MotionCounters take_counters(Workspace& workspace);

  std::int32_t width() const { return model_.width; }

  // `kinematic_error`: of the computed poses, m.
  MotionReport check(const Kinematics& kinematics, const double* q0, const double* q1, double tolerance,
                     double kinematic_error, Workspace& workspace) const;
  // The same in the order of the motion: where it is refused first. With `proofs`, notes down those of all pairs, which
  // takes longer since no bounds settle anything.
  MotionReport explain(const Kinematics& kinematics, const double* q0, const double* q1, double tolerance,
                       double kinematic_error, std::vector<MotionProof>* proofs, Workspace& workspace) const;
  // Configurations (n, width) at parameters of a motion.
  void states(const double* q0, const double* q1, const double* t, std::size_t n, double* q) const;

 private:
  friend class MotionRun;

  MotionModel model_;
  bool hints_;
  std::vector<std::int32_t> movers_;          // bodies that move and are in a pair
  std::vector<std::int32_t> frames_;          // links
  std::vector<std::int32_t> among_self_;      // pairs of which both bodies move
  std::vector<std::int32_t> still_;           // bodies that stand still
  std::vector<double> defects_;               // per body that stands still: how far its placement is off rigid
  std::vector<double> still_bounds_;          // six rows: low and high corners of their boxes in the world
  std::size_t still_row_ = 0;                 // length of a row: whole lanes
  std::vector<std::int32_t> pair_of_;         // mover's position * still_row_ + still body's position: the pair, or −1
  std::vector<std::int32_t> chain_in_world_;  // per mover: its chain from the world, −1 if it is in no such pair
  // How far bodies reach: those that stand still from the world's origin, the others from their links', m.
  double still_size_ = 0, mounted_size_ = 0;

  void bound_still();
  void find_near(std::size_t mover, Vec3 low, Vec3 high, std::vector<std::int32_t>& found) const;
};

}  // namespace plannercheck
