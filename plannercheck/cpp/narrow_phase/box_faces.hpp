// The face of a box around one of two bodies that comes nearest to separating both boxes: whether it separates the
// bodies.
//
// Errors are within those that PairFrame::separates allows for mixtures of polar points (pair_frame.cpp). Over the
// B, q·x exceeds 1 by 3u for a face of its own; for one of A's by 20u of r_Q and B's reach, of which
// 14u are the scan's. The least q·x over A is that of any plane; by A's box it errs by 8u less.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// B has a polar. Undecided if that plane does not separate the bodies; faces of boxes before a body that is a
// box itself have been tried by PairFrame::boxes_apart.
Certificate box_face(const PairFrame& frame, PairCounters& counters);

}  // namespace plannercheck
