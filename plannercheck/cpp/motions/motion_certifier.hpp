// Motions that are proved free, not sampled: the straight segment between two configurations, joint by joint.
//
// In: posed bodies on links, pairs of them, chains of joints with lever arms (motion_bounds), a motion. Out: whether it
// is free; if not, up to which parameter it is proved free, and where and why it is refused.
//
// Idea. The motion is cut into intervals. Seen from a frame between the two bodies of a pair, a point's path over an
// interval of length h leaves its chord by at most h²/8 times a bound of |p''|. Fix a direction n in that frame. The
// gap of the bodies along n is at least the interpolation of the gaps at both ends, less ε = h²/8 (the sum of both
// bodies' bounds). So if some n keeps the bodies more than ε apart at both ends, they are apart throughout. The search
// for n takes the fastest tests first, one state in each lane: boxes around whole paths, bounding spheres on chords
// against boxes, boxes along the plane that separated the pair last time, hulls along it, and finally swept_distance.
// If a pair has no such n, its interval is cut finer. Since ε shrinks with h², a clearance c needs h of about √c.
//
// A motion is refused only if, at a state on it, a pair is proved to be within `tolerance` (touching included).
//
// Immutable: each thread brings a workspace. Only planes in it outlive a motion, as hints. A hint settles only pairs
// that the motion's own planes would settle, too, so verdicts do not depend on earlier motions.
#pragma once

#include <memory>

#include "checking/checker.hpp"
#include "motions/motion_bounds.hpp"
#include "motions/motion_report.hpp"
#include "motions/path.hpp"
#include "motions/piece_covers.hpp"

namespace plannercheck {

// Two bodies; the first one moves. Frame: the link whose rotation the frame has, −1 for the world. Chains: from the
// frame to each body, −1 if the body stands still in the frame. A half-space is the second body.
struct CertifiedPair {
  std::int32_t a, b, frame, chain_a, chain_b;
  Kind kind = Kind::kHull;
};

struct MotionModel {
  std::vector<GeometryObject> bodies;  // link −1: static at its placement
  std::vector<CertifiedPair> pairs;
  MotionChains chains;
  std::vector<PathPart> parts;
  std::int32_t width = 0, links = 0;
  double defect = 0;    // sum over all placements, axes and held joints of how far each is off rigid
  double leverage = 1;  // sum of |multiplier|: how much all joints turn for one unit of all columns
  double depth = 0;     // largest number of parts (circles, quaternions) on a chain from the world
  // How far joints and links may be from the world's origin, m: with all columns at 0, then for each unit of a column.
  double extent = 0;
  std::vector<double> travel;
  double joints = 0;  // largest number on a chain
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

class ChainTable;
class MotionScreen;
class MotionCollisions;
class PartClearances;
class RecentRate;

class MotionCertifier {
 public:
  // `states`: judges states by the same pairs, less the pairs that never move relative to each other and are apart;
  // null for none.
  MotionCertifier(MotionModel model, const Tuning& tuning, std::shared_ptr<const CheckerCore> states = nullptr);

  struct Workspace;  // incomplete here, since it holds lanes
  std::shared_ptr<Workspace> new_workspace() const;
  // The counts since the last call.
  static MotionCounters take_counters(Workspace& workspace);

  std::int32_t width() const { return model_.width; }

  // The answers of n motions. `kinematic_error`: bounds the error of the computed poses, m.
  void check(const Kinematics& kinematics, const Segments& motions, std::size_t n, double tolerance,
             double kinematic_error, std::uint8_t* answers, Workspace& workspace) const;
  // The answers of n pieces with tubes. One straight motion may prove several pieces in a row (piece_covers.hpp).
  // `range`: where the kinematic error holds.
  void check_pieces(const Kinematics& kinematics, const Segments& pieces, std::size_t n, double tolerance,
                    double kinematic_error, const PoseRange& range, std::uint8_t* answers, Workspace& workspace) const;
  // Checks one motion in its order: where it is refused first. With `proofs`, records the proofs of all pairs, which
  // takes longer since no bounds settle anything.
  MotionReport explain(const Kinematics& kinematics, const Segment& motion, double tolerance, double kinematic_error,
                       std::vector<MotionProof>* proofs, Workspace& workspace) const;
  // Configurations (n, width) at parameters of a motion.
  void states(const Segment& motion, const double* t, std::size_t n, double* q) const;

 private:
  friend class MotionPairs;
  friend class MotionRun;

  MotionModel model_;
  Tuning tuning_;
  std::shared_ptr<const CheckerCore> states_;
  std::vector<std::int32_t> movers_;  // bodies that move and are in a pair
  std::vector<std::int32_t> frames_;  // links
  bool has_parts_ = false;            // whether a pair has a set of parts
  std::vector<double> defects_;       // per static body: how far its placement is off rigid
  // These hold lanes or are used with them.
  std::shared_ptr<const ChainTable> chain_table_;
  std::shared_ptr<const MotionScreen> screen_;
  std::shared_ptr<const MotionCollisions> collisions_;
  std::shared_ptr<const PartClearances> clearances_;
  // How far bodies extend: static ones from the world's origin, the others from their links', m.
  double still_size_ = 0, mounted_size_ = 0;

  // Some of the motions at once, and a place on them.
  struct Look {
    std::size_t place, first, past;
  };

  // Judges states of `count` <= kMotionsAtOnce motions: whether those that are looked at are free.
  void judge_states(const Kinematics& kinematics, const Segments& motions, std::size_t count,
                    Workspace& workspace) const;
  void try_all_looks(const Kinematics& kinematics, const Segments& motions, std::size_t count,
                     Workspace& workspace) const;
  void judge_at(const Kinematics& kinematics, const Segments& motions, const Look& look, RecentRate& rate,
                Workspace& workspace) const;
};

}  // namespace plannercheck
