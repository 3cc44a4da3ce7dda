#include "centre_axis.hpp"

namespace plannercheck {

bool CentreAxis::separates_bodies(std::int32_t* lowest, PairCounters& counters) const {
  const double length = norm(axis_);
  const double room = length * (swell_ * (1 + kSlack) + kSlack * (length + radii_) + rounding_);
  ++counters.guest_queries;
  *lowest = extreme(guest_.body->inner, -guest_.pose.rotate_back(axis_), counters.queries);
  const Vec3 p = guest_.pose.apply(guest_.body->inner.points[at(*lowest)]);
  if (!(dot(axis_, p - host_.pose.apply(host_.body->centre)) > room)) return false;
  ++counters.host_queries;
  const std::int32_t highest = extreme(host_.body->inner, host_.pose.rotate_back(axis_), counters.queries);
  return dot(axis_, p - host_.pose.apply(host_.body->inner.points[at(highest)])) > room;
}

// Scaled, the plane touches the host's ball; a point has none, but no polar either, so no plane of it is cached.
Certificate CentreAxis::certificate(bool scaled) const {
  Certificate out;
  out.answer = Answer::kSeparated;
  out.stage = Stage::kCentreAxis;
  out.q = host_.pose.rotate_back(axis_);
  if (scaled) out.q = 1 / (host_.body->radius * norm(axis_) * (1 + kSlack)) * out.q;
  return out;
}

}  // namespace plannercheck
