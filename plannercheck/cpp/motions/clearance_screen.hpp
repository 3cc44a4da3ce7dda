// On which intervals of a motion's grid a body is surely far from all parts of a set that stands still, by look-ups.
//
// In: a pair, what its clearances are looked up in, a grid of states. Out: the intervals left open, one bit each. Idea:
// each of the balls that together hold the body is far from all parts near the middle state if its clearance there is
// longer than the way; and between two states if its clearances at both are, together, longer than the way.
//
// Proof. Let a ball's centre go along the chord from a to b, and let x divide it into s and t. The clearance C changes
// by no more than the way: C(x) >= C(m) − |x m| for any m, and 2 C(x) >= C(a) − s + C(b) − t = C(a) + C(b) − |a b|. On
// the motion the centre is no further from x than the chord deviation, and the ball's points no further than its
// radius.
#pragma once

#include "broad_phase/part_clearances.hpp"
#include "motions/motion_filters.hpp"
#include "motions/motion_grid.hpp"

namespace plannercheck {

// Of the intervals `near` those left open. `beyond`: how much further away than it needs the pair has to be, m.
unsigned near_by_clearances(const PartClearances& clearances, const CertifiedPair& pair, const MotionFilters& filters,
                            const MotionGrid& grid, double beyond, unsigned near);

}  // namespace plannercheck
