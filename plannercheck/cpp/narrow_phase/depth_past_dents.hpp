// Whether a point that two hulls share proves that the bodies, which have dents (hull_dents.hpp), share a point.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// `x`: in the frame, a mixture of A vertices that B's hull contains by `value`; see PairFrame::contains.
bool is_past_dents(const PairFrame& frame, Vec3 x, double value, long mixtures, PairCounters& counters);
inline bool bodies_hold(const PairFrame& frame, Vec3 x, double value, long mixtures, PairCounters& counters) {
  return frame.contains(value, mixtures) && (!frame.has_dents() || is_past_dents(frame, x, value, mixtures, counters));
}

}  // namespace plannercheck
