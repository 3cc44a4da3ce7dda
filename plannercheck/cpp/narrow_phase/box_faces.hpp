// The face of a box around one of two bodies that comes nearest to separating both boxes: whether it separates the
// bodies.
//
// Errors are within those that PairFrame::separates allows for mixtures of polar points (pair_frame.cpp). Over the
// host, q·x exceeds 1 by 3u for a face of its own; for one of the guest's by 20u of r_Q and the host's reach, of which
// 14u are the scan's. The least q·x over the guest is that of any plane; by the guest's box it errs by 8u less.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// The host has a polar. Undecided if that plane does not separate the bodies; faces of boxes before a body that is a
// box itself have been tried by PairFrame::boxes_apart.
Certificate box_face(const PairFrame& frame, PairCounters& counters);

}  // namespace plannercheck
