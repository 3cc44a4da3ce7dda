// Motions of planar robots that are proved free, not sampled.
//
// In: a chain of links, convex polygons on links or in the world, pairs of them, a motion of pieces. Out: whether it is
// free; if not, up to which parameter it is proved free, and where and why it is refused.
//
// The idea is as in motion_certifier.hpp: a piece is cut into intervals; along a direction fixed in a pair's frame the
// gap of the bodies is at least the smaller gap at both ends less ε = h²/8 (the sum of both bodies' bounds of |p''|).
// The search for a direction with a larger gap at both ends takes the fastest tests first: boxes around paths, circles
// on chords against boxes, the last direction, a descent on the sets that both bodies sweep. If there is none, the
// interval is cut finer. Without turning, ε is 0, and a whole piece is settled at once. A motion is refused only if a
// pair is proved to be within `tolerance` at a state on it.
//
// Immutable: each thread brings a workspace. Nothing in it outlives a motion, so no verdict depends on earlier ones.
#pragma once

#include <memory>

#include "motions/motion_report.hpp"
#include "planar/motion_bounds_2d.hpp"
#include "planar/swept_distance_2d.hpp"

namespace plannercheck {

// Pieces in order; joints go from q0 to q1 (rows of configurations). `given`: the end before whole turns were taken off
// its angles, which rounds them by a part of their given values.
struct PlanarMotion {
  const double *q0, *q1, *given;
  const PlanarPiece* pieces;
  std::size_t count;
};

using PlanarProof = IntervalProof<PlanarDirection>;

// The frame from which a pair's paths are seen: a link, or -1 for the world.
struct PlanarMotionPair {
  std::int32_t a, b, frame;
  PlanarChain chain_a, chain_b;
};

class PlanarCertifier {
 public:
  PlanarCertifier(std::vector<PlanarLink> links, std::int32_t width, std::vector<PlanarGeometryObject> bodies,
                  const std::vector<std::array<std::int32_t, 2>>& pairs);

  struct Workspace;  // incomplete here, since it holds lanes
  std::shared_ptr<Workspace> new_workspace() const;
  // The counts since the last call.
  static GridCounters take_counters(Workspace& workspace);

  // Per pair: the frame of its proofs.
  std::vector<std::int32_t> frames() const;
  // The straight motion as a piece.
  PlanarPiece straight(const double* q0, const double* q1) const;
  MotionReport check(const PlanarMotion& motion, double tolerance, Workspace& workspace) const;
  // Checks in the order of the motion: where it is refused first. With `proofs`, records the proofs of all pairs.
  MotionReport explain(const PlanarMotion& motion, double tolerance, std::vector<PlanarProof>* proofs,
                       Workspace& workspace) const;
  // Configurations (n, width) at parameters.
  void states(const PlanarMotion& motion, const double* t, std::size_t n, double* q, Workspace& workspace) const;

 private:
  friend class PlanarRun;
  friend class PlanarGrid;

  std::vector<PlanarLink> links_;
  std::size_t width_;
  std::vector<PlanarGeometryObject> bodies_;
  std::vector<PlanarHull> hulls_;  // of bodies in the world, posed
  std::vector<PlanarMotionPair> pairs_;
  std::vector<std::int32_t> movers_;  // bodies on links that are in a pair
  double reach_ = 0, anchor_turns_ = 0;
  double still_size_ = 0;  // largest distance of bodies in the world from the origin, m

  // The bound of all rounding, m.
  double rounding(const PlanarMotion& motion) const;
};

}  // namespace plannercheck
