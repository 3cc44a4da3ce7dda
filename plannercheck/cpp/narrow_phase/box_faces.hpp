// Whether the face of a box that most nearly separates the boxes around two bodies separates the bodies.
//
// Errors are within the errors that PairFrame::separates allows for mixtures of polar points (pair_frame.cpp). Over B,
// q·x exceeds 1 by 3u for a face of B's box, and by 20u of r_Q and B's reach for a face of A's box, of which 14u are
// the scan's. The least q·x over A is computed as for any plane; by A's box it errs by 8u less.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// B has a polar. Undecided if that plane does not separate the bodies; faces of boxes before a body that is a
// box itself have been tried by PairFrame::boxes_apart.
Certificate box_face(const PairFrame& frame, PairCounters& counters);

}  // namespace plannercheck
