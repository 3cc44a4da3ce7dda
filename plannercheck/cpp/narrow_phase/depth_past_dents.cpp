#include "narrow_phase/depth_past_dents.hpp"

namespace plannercheck {

bool is_past_dents(const PairFrame& frame, Vec3 x, double value, long mixtures, PairCounters& counters) {
  const Vec3 inner = frame.past_dents_of_a(x);
  // No facet's product grows by more than the way times the longest polar point.
  const double most = value + frame.body_b().polar_radius * norm(inner - x) * (1 + 0x1p-40);
  if (frame.is_past_dents_of_b(inner, most, mixtures)) return true;
  ++counters.queries_b;
  const std::int32_t k = extreme(frame.body_b().polar, inner, counters.queries);
  return frame.is_past_dents_of_b(inner, dot(frame.polar_point(k), inner), mixtures);
}

}  // namespace plannercheck
