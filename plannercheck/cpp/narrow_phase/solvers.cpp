#include "narrow_phase/solvers.hpp"

namespace plannercheck {

bool still_separates(const PairFrame& frame, Vec3 q, long mixtures, PairCounters& counters) {
  ++counters.guest_queries;
  const std::int32_t p = extreme(frame.guest().inner, frame.guest_direction(q), counters.queries);
  return frame.separates(q, dot(q, frame.guest_vertex(p)), mixtures);
}

}  // namespace plannercheck
