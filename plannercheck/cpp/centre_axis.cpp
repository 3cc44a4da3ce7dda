#include "centre_axis.hpp"

namespace plannercheck {

Certificate CentreAxis::decide(bool scaled, std::int32_t* lowest, PairCounters& counters) const {
  if (is_within_swell(axis_)) return shared(host_centre_, axis_);
  const double length = norm(axis_);
  const double room = length * (swell_ * (1 + kSlack) + kSlack * (length + radii_) + rounding_);
  ++counters.guest_queries;
  *lowest = extreme(guest_.body->inner, -guest_.pose.rotate_back(axis_), counters.queries);
  const Vec3 p = guest_.pose.apply(guest_.body->inner.points[at(*lowest)]);
  if (!(dot(axis_, p - host_centre_) > room)) return {};
  ++counters.host_queries;
  const std::int32_t highest = extreme(host_.body->inner, host_.pose.rotate_back(axis_), counters.queries);
  const Vec3 r = host_.pose.apply(host_.body->inner.points[at(highest)]);
  if (dot(axis_, p - r) > room) return separated(scaled);
  return is_within_swell(p - r) ? shared(r, p - r) : Certificate{};
}

// Scaled, the plane touches the host's ball; a point has none, but no polar either, so no plane of it is cached.
Certificate CentreAxis::separated(bool scaled) const {
  Certificate out;
  out.answer = Answer::kSeparated;
  out.stage = Stage::kCentreAxis;
  out.q = host_.pose.rotate_back(axis_);
  if (scaled) out.q = 1 / (host_.body->radius * norm(axis_) * (1 + kSlack)) * out.q;
  return out;
}

// `between` leads from a point of the host's hull to one of the guest's: it is divided as the swells are.
Certificate CentreAxis::shared(Vec3 on_host, Vec3 between) const {
  Certificate out;
  out.answer = Answer::kShared;
  out.stage = Stage::kCentreAxis;
  out.x = host_.pose.rotate_back(on_host + (host_.body->swell / swell_) * between - host_centre_);
  return out;
}

}  // namespace plannercheck
