// The face of a box around one of two bodies that comes nearest to separating both boxes: whether it separates the
// bodies.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// The host has a polar. Undecided if that plane does not separate the bodies; faces of boxes before a body that is a
// box itself have been tried by PairFrame::boxes_apart.
Certificate box_face(const PairFrame& frame, PairCounters& counters);

}  // namespace plannercheck
