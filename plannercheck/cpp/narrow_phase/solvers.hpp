// The solvers of the pair test. Each ends with a certificate that has been checked, or undecided: none ever guesses.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// The coupled walk of Barba and Langerman, section "Detecting intersections in 3D": O(log |P| + log |R|) rounds.
Certificate coupled_walk(const PairFrame& frame, PairCounters& counters);

// Small active sets on both sides; their game decides which of the two hierarchies is asked for one more.
Certificate double_oracle(const PairFrame& frame, std::int32_t guest_vertex, PairCounters& counters);

// Whether q, a separating plane found for other poses of the same pair, still separates.
bool still_separates(const PairFrame& frame, Vec3 q, long mixtures, PairCounters& counters);

}  // namespace plannercheck
