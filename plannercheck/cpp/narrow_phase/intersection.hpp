// The test of one pair, fastest stage first: each stage ends with a certificate or leaves the pair to the next; the
// last is exact.
#pragma once

#include <optional>

#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/exact_stage.hpp"
#include "narrow_phase/gjk.hpp"
#include "narrow_phase/gjk_double_double.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

enum class Solver { kDoubleOracle, kWalk, kExact };

// Every optimisation can be turned off; verdicts depend on none.
struct PairOptions {
  Solver solver = Solver::kDoubleOracle;
  bool cached_plane = true;
  bool box_face = true;  // of pairs whose boxes meet
  bool centre_axis = true;
  bool turned_axis = true;     // whether the axis is turned to where equivalent ellipsoids face each other
  bool nearest_points = true;  // the second filter
  bool double_double = true;   // the third filter; without both, exact arithmetic decides what the solver leaves
  bool warm_start = true;      // whether each stage begins with the vertices where the one before gave up
  bool trees_first = true;     // whether solids whose hulls met last are tested before their hulls
  bool dents = true;           // whether hulls that meet deeper than the dents of their solids decide the pair
  bool part_trees = true;      // of boxes, of sets of parts; off, each part is tested by itself
};

// The plane that separated a pair last time, in B's frame.
struct CachedPlane {
  Vec3 q;
  std::int32_t mixtures = 0;
  bool valid = false;
};

// What earlier poses of a pair have shown. No verdict depends on it.
struct PairMemory {
  CachedPlane plane;
};

struct PairVerdict {
  bool shared = false;  // by the hulls
  // Whether `shared` also holds for the bodies: false for solids, unless their hulls meet deeper than the solids'
  // dents. If they meet about as deep as the dents, `shared` only means that the hulls may meet.
  bool settles = true;
  Stage stage = Stage::kSolver;
  Certificate certificate;           // up to stage kSolver
  Proximity proximity;               // stages kNearest and kDoubleDouble
  std::optional<ExactAnswer> exact;  // stage kExact
};

// A direction from B to A, in the world, for bodies that are apart; exact in the last two stages.
struct FoundDirection {
  Vec3 rounded;
  std::optional<DyadicVec3> exact;
};
FoundDirection direction_found(const PairVerdict& verdict, const PosedPolytope& body_b);

// The verdict of a certificate that is not undecided; caches its plane.
PairVerdict certified(const Certificate& certificate, PairMemory* memory);

// Which body becomes B: the one whose polar is better conditioned; 0 for `a`, 1 for `b`. Bodies without volume have no
// polar.
int choose_b(const Polytope& a, const Polytope& b);

// `likely`: most poses of this pair share a point, so such a certificate is sought first. Verdicts do not depend on it.
PairVerdict test_pair(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairFrame& frame, bool likely,
                      const PairOptions& options, PairMemory* memory, PairCounters& counters);
PairVerdict test_pair(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairOptions& options,
                      PairMemory* memory, PairCounters& counters);

// Whether the balls around the centres are apart, and options allow to decide by them; takes no support query.
inline bool is_far(const CentreAxis& axis, const PairOptions& options) {
  return options.centre_axis && options.solver != Solver::kExact && axis.separates_balls();
}
// The test of a pair for which `is_far` is false. `axis` may be turned.
PairVerdict test_close_pair(const PosedPolytope& body_a, const PosedPolytope& body_b, CentreAxis& axis,
                            const PairOptions& options, PairMemory* memory, PairCounters& counters);

}  // namespace plannercheck
