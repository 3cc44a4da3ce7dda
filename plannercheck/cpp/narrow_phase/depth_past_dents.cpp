#include "narrow_phase/depth_past_dents.hpp"

namespace plannercheck {

bool is_past_dents(const PairFrame& frame, Vec3 x, double value, long mixtures, PairCounters& counters) {
  const Vec3 inner = frame.past_guest_dents(x);
  // No facet's product grows by more than the way times the longest polar point.
  const double most = value + frame.host().polar_radius * norm(inner - x) * (1 + 0x1p-40);
  if (frame.is_past_host_dents(inner, most, mixtures)) return true;
  ++counters.host_queries;
  const std::int32_t k = extreme(frame.host().polar, inner, counters.queries);
  return frame.is_past_host_dents(inner, dot(frame.polar_point(k), inner), mixtures);
}

}  // namespace plannercheck
