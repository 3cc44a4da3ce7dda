#include "solvers.hpp"

namespace plannercheck {

bool still_separates(const PairFrame& frame, Vec3 q, long mixtures, PairCounters& counters) {
  ++counters.guest_queries;
  const std::int32_t p = extreme(frame.guest().inner, frame.guest_direction(q), counters.queries);
  return frame.separates(q, dot(q, frame.guest_vertex(p)), mixtures);
}

Certificate centre_axis(const PairFrame& frame, std::int32_t* lowest, PairCounters& counters) {
  Certificate certificate;
  const Vec3 axis = frame.guest_centre();
  ++counters.guest_queries;
  *lowest = extreme(frame.guest().inner, frame.guest_direction(axis), counters.queries);
  const double below = dot(axis, frame.guest_vertex(*lowest));
  if (!(below > 0)) return certificate;
  // The support of R along the axis comes from its vertices; scaled to it, the plane touches R.
  ++counters.host_queries;
  const Body& host = frame.host();
  const auto r = static_cast<std::size_t>(extreme(host.inner, axis, counters.queries));
  const double support = dot(axis, host.inner.points[r] - host.centre);
  if (!(support > 0) || !frame.separates((1 / support) * axis, below / support)) return certificate;
  certificate.answer = Answer::kSeparated;
  certificate.stage = Stage::kCentreAxis;
  certificate.q = (1 / support) * axis;
  return certificate;
}

}  // namespace plannercheck
