// Whether the parts of a set are further than a limit from another body, at one pose or at the ends of intervals.
//
// In: a set and another body that is no set, posed, and the frame in which directions are fixed. Out: whether each part
// is further than the limit from the body along some direction, the same at all poses. Idea: a descent in the set's
// tree skips nodes whose boxes are apart along a known direction: the axes of both bodies at the first pose, or a
// direction that separated other parts. The distance descent tries each remaining part, and its direction is stored for
// the neighbours.
#pragma once

#include "motions/swept_distance.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// `count` poses, one at least; the ends of successive intervals settle all of these intervals. The radii of parts
// count, but the bodies' inflation radii do not: the limit has to include them. If both bodies are sets, each part of
// the smaller set is compared with the larger set. Always false at more than two poses of a set that moves in the
// frame. A solid counts as its hull. Rounding of posed points and of products with directions is some fifty u of their
// coordinates, as in swept_distance. `trees`: off, each part is tried by a descent of its own.
bool parts_further(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit,
                   PairCounters& counters, bool trees = true);

}  // namespace plannercheck
