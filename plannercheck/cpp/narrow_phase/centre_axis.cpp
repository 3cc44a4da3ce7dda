#include "narrow_phase/centre_axis.hpp"

namespace plannercheck {

Certificate CentreAxis::decide(bool scaled, std::int32_t* lowest, PairCounters& counters) const {
  if (is_within_inflation_radius(between_centres_)) return shared(centre_b_, between_centres_);
  const Levels &body_a = body_a_.body->inner, &body_b = body_b_.body->inner;
  ++counters.queries_a;
  *lowest = extreme(body_a, -body_a_.pose.rotate_back(axis_), counters.queries);
  const Vec3 p = body_a_.pose.apply(body_a.points[at(*lowest)]);
  if (!(dot(axis_, p - centre_b_) > room())) return {};  // the axis can't separate
  ++counters.queries_b;
  const std::int32_t highest = extreme(body_b, body_b_.pose.rotate_back(axis_), counters.queries);
  const Vec3 r = body_b_.pose.apply(body_b.points[at(highest)]);
  if (dot(axis_, p - r) > room()) return separated(scaled);
  return is_within_inflation_radius(p - r) ? shared(r, p - r) : Certificate{};
}

Certificate CentreAxis::separated(bool scaled) const {
  Certificate out;
  out.answer = Answer::kSeparated;
  out.stage = Stage::kCentreAxis;
  out.q = scaled ? touching_ball(axis_) : body_b_.pose.rotate_back(axis_);
  return out;
}

// `between` leads from a point of B's hull to one of A's; the shared point divides it as the inflation
// radii do.
Certificate CentreAxis::shared(Vec3 on_body_b, Vec3 between) const {
  Certificate out;
  out.answer = Answer::kShared;
  out.stage = Stage::kCentreAxis;
  out.x =
      body_b_.pose.rotate_back(on_body_b + (body_b_.body->inflation_radius / inflation_radius_) * between - centre_b_);
  return out;
}

}  // namespace plannercheck
