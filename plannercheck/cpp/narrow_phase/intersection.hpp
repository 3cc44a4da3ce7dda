// The test of one pair: cheapest step first, each ending with a certificate or handing on, the last one exact.
#pragma once

#include <optional>

#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/exact_stage.hpp"
#include "narrow_phase/gjk.hpp"
#include "narrow_phase/gjk_double_double.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

enum class Solver { kDoubleOracle, kWalk, kExact };

// Every clever step can be turned off; verdicts do not depend on it.
struct PairOptions {
  Solver solver = Solver::kDoubleOracle;
  bool cached_plane = true;
  bool centre_axis = true;
  bool turned_axis = true;  // whether that is turned to where the bodies would face each other if they were ellipsoids
  bool facet_plane = true;
  bool nearest_points = true;  // the second filter
  bool double_double = true;   // the third filter; without both, exact arithmetic decides what the solver leaves
  bool warm_start = true;      // whether each of these begins with the vertices where the one before gave up
  bool interleaving = true;    // whether a batch has several pairs of large bodies under way
};

// The plane that separated a pair last time, in the host's frame.
struct CachedPlane {
  bool valid = false;
  Vec3 q;
  long mixtures = 0;
};

struct PairVerdict {
  bool shared = false;
  Stage stage = Stage::kSolver;
  Certificate certificate;           // up to stage kSolver
  Proximity proximity;               // stages kNearest and kDouble2
  std::optional<ExactAnswer> exact;  // stage kExact
};

// Of the solver's certificate, or of what comes after it where that is undecided.
PairVerdict concluded(const PairFrame& frame, const Certificate& certificate, const PairOptions& options,
                      CachedPlane* cache, PairCounters& counters);

// Of a certificate that is not undecided; keeps its plane.
PairVerdict certified(const Certificate& certificate, CachedPlane* cache);

// Of two bodies the one whose polar is better conditioned hosts: 0 for `a`, 1 for `b`. Bodies without volume have none.
int choose_host(const Body& a, const Body& b);

// `likely`: most poses of this pair share a point, so a certificate of that is sought first. Verdicts do not depend on
// it.
PairVerdict test_pair(const PairFrame& frame, bool likely, const PairOptions& options, CachedPlane* cache,
                      PairCounters& counters);
PairVerdict test_pair(const PosedBody& guest, const PosedBody& host, const PairOptions& options, CachedPlane* cache,
                      PairCounters& counters);

// Whether the axis between the centres may settle it and does so by the balls around them, which takes no query.
inline bool is_far(const CentreAxis& axis, const PairOptions& options) {
  return options.centre_axis && options.solver != Solver::kExact && axis.separates_balls();
}
// The test of a pair that is not far. `axis` may be turned.
PairVerdict test_close_pair(const PosedBody& guest, const PosedBody& host, CentreAxis& axis, const PairOptions& options,
                            CachedPlane* cache, PairCounters& counters);

}  // namespace plannercheck
