// Whether the parts of a set are further than a limit from another body, at one pose or at the ends of intervals.
//
// In: a set and a body that is none, posed, and the frame in which directions are kept. Out: whether each part is
// further than the limit from the body along a direction of its own, the same at all poses. Idea: nodes of the set's
// tree end where one of a few directions keeps their boxes away, those of both bodies' axes at the first pose and those
// that kept other parts away; a part that is left is tried by a descent, whose direction is kept for its neighbours.
#pragma once

#include "motions/swept_distance.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// `count` poses, one at least; those of intervals that follow one another settle them all. The bodies' inflation radii
// are not counted, the radii of parts are: the limit has to include the former. Of two sets, each part of the smaller
// one is held against the larger one. False at more than two poses of a set that moves in the frame. Of a solid its
// hull is taken. Rounding of posed points and of products with directions is some fifty u of their coordinates, as in
// swept_distance. `trees`: off, each part is tried by a descent of its own.
bool parts_further(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit,
                   PairCounters& counters, bool trees = true);

}  // namespace plannercheck
