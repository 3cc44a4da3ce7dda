#include "narrow_phase/centre_axis.hpp"

namespace plannercheck {

Certificate CentreAxis::decide(bool scaled, std::int32_t* lowest, PairCounters& counters) const {
  if (is_within_inflation_radius(between_centres_)) return shared(host_centre_, between_centres_);
  const Levels &guest = guest_.body->inner, &host = host_.body->inner;
  ++counters.guest_queries;
  *lowest = extreme(guest, -guest_.pose.rotate_back(axis_), counters.queries);
  const Vec3 p = guest_.pose.apply(guest.points[at(*lowest)]);
  if (!(dot(axis_, p - host_centre_) > room())) return {};  // the axis can't separate
  ++counters.host_queries;
  const std::int32_t highest = extreme(host, host_.pose.rotate_back(axis_), counters.queries);
  const Vec3 r = host_.pose.apply(host.points[at(highest)]);
  if (dot(axis_, p - r) > room()) return separated(scaled);
  return is_within_inflation_radius(p - r) ? shared(r, p - r) : Certificate{};
}

Certificate CentreAxis::separated(bool scaled) const {
  Certificate out;
  out.answer = Answer::kSeparated;
  out.stage = Stage::kCentreAxis;
  out.q = scaled ? touching_ball(axis_) : host_.pose.rotate_back(axis_);
  return out;
}

// `between` leads from a point of the host's hull to one of the guest's; the shared point divides it as the inflation
// radii do.
Certificate CentreAxis::shared(Vec3 on_host, Vec3 between) const {
  Certificate out;
  out.answer = Answer::kShared;
  out.stage = Stage::kCentreAxis;
  out.x = host_.pose.rotate_back(on_host + (host_.body->inflation_radius / inflation_radius_) * between - host_centre_);
  return out;
}

}  // namespace plannercheck
