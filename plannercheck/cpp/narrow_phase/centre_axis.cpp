#include "narrow_phase/centre_axis.hpp"

namespace plannercheck {

Certificate CentreAxis::decide(Vec3 of_guest, Vec3 of_host, bool scaled) const {
  const Vec3 p = guest_.pose.apply(of_guest), r = host_.pose.apply(of_host);
  if (dot(axis_, p - r) > room()) return separated(scaled);
  return is_within_inflation_radius(p - r) ? shared(r, p - r) : Certificate{};
}

Certificate CentreAxis::decide(bool scaled, std::int32_t* lowest, PairCounters& counters) const {
  if (centres_share()) return shared_by_centres();
  ++counters.guest_queries;
  *lowest = extreme(guest_.body->inner, towards_host(), counters.queries);
  const Vec3 of_guest = guest_.body->inner.points[at(*lowest)];
  if (!is_beyond_centre(of_guest)) return {};
  ++counters.host_queries;
  const std::int32_t highest = extreme(host_.body->inner, towards_guest(), counters.queries);
  return decide(of_guest, host_.body->inner.points[at(highest)], scaled);
}

bool CentreAxis::separates(Vec3 direction, double defect, PairCounters& counters) const {
  const Levels &guest = guest_.body->inner, &host = host_.body->inner;
  ++counters.guest_queries, ++counters.host_queries;
  const std::int32_t lowest = extreme(guest, -guest_.pose.rotate_back(direction), counters.queries);
  const std::int32_t highest = extreme(host, host_.pose.rotate_back(direction), counters.queries);
  const Vec3 p = guest_.pose.apply(guest.points[at(lowest)]), r = host_.pose.apply(host.points[at(highest)]);
  return dot(direction, p - r) > room(direction, 2 * defect);
}

Certificate CentreAxis::separated(bool scaled) const {
  const Vec3 q = scaled ? touching_ball(axis_) : host_.pose.rotate_back(axis_);
  return {.answer = Answer::kSeparated, .stage = Stage::kCentreAxis, .q = q};
}

// `between` leads from a point of the host's hull to one of the guest's; the shared point divides it as the inflation
// radii do.
Certificate CentreAxis::shared(Vec3 on_host, Vec3 between) const {
  const Vec3 point = on_host + (host_.body->inflation_radius / inflation_radius_) * between;
  return {.answer = Answer::kShared, .stage = Stage::kCentreAxis, .x = host_.pose.rotate_back(point - host_centre_)};
}

}  // namespace plannercheck
