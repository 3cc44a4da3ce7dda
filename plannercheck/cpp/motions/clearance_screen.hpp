// On which intervals of a motion's grid a body is surely far from all parts of a static set, by look-ups.
//
// In: a pair, its clearance grid, a grid of states. Out: the open intervals, one bit each. Idea: some balls together
// hold the body. A ball is far from all parts near the middle state if its clearance at that state exceeds the distance
// travelled, and between two states if the sum of its clearances at both exceeds the distance travelled.
//
// Proof. Let a ball's centre go along the chord from a to b, and let x divide it into s and t. The clearance C changes
// by no more than the distance: C(x) >= C(m) − |x m| for any m, and 2 C(x) >= C(a) − s + C(b) − t = C(a) + C(b) − |a
// b|. On the motion the centre is no further from x than the chord deviation, and the ball's points no further than its
// radius.
#pragma once

#include "broad_phase/part_clearances.hpp"
#include "motions/motion_filters.hpp"
#include "motions/motion_grid.hpp"

namespace plannercheck {

// The intervals of `near` that stay open. `beyond`: by how much more than needed the pair has to be apart, m.
unsigned near_by_clearances(const PartClearances& clearances, const CertifiedPair& pair, const MotionFilters& filters,
                            const MotionGrid& grid, double beyond, unsigned near);

}  // namespace plannercheck
