// How two bodies are tested: a table with one row for each kind of pair (bodies/polytope.hpp).
//
// In: two posed bodies. Out: exact verdicts, what the bodies share, distances between proved bounds. Two hulls are
// tested by intersection.hpp; a solid by its triangles, where hulls do not decide (solid_pair.hpp); a set part by part
// (part_pair.hpp); a half-space along its normal (half_space_pair.hpp).
#pragma once

#include "narrow_phase/distance.hpp"
#include "narrow_phase/solid_pair.hpp"

namespace plannercheck {

struct PairKernel {
  // Whether two bodies share a point. `b` should be B, see choose_b; verdicts do not depend on it.
  bool (*share)(const PosedPolytope& a, const PosedPolytope& b, const PairOptions& options, PairCounters& counters);
  // What they share. `guess`: where the pair met last; it only saves time.
  SolidContact (*contact)(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                          PairCounters& counters, const SolidOptions& options, SolidCounters* counted);
  // See pair_distance and distance_bound.
  PairDistance (*distance)(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit,
                           PairCounters& counters, const PartVisitor* visit);
  double (*bound)(const PosedPolytope& body_a, const PosedPolytope& body_b, int rounds, PairCounters& counters);
};

extern const KindTable<PairKernel> kPairKernels;

// The functions of these names, for two bodies of any kind.
bool share_a_point(const PosedPolytope& a, const PosedPolytope& b, const PairOptions& options, PairCounters& counters);
SolidContact contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess, PairCounters& counters,
                     const SolidOptions& options = {}, SolidCounters* counted = nullptr);

}  // namespace plannercheck
