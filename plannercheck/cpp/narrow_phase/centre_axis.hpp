// The axis between the centres of two posed bodies. It separates most bodies that are far apart, and shows that round
// ones are within each other's inflation radius. It may be turned to another axis, which separates long and flat bodies
// more often.
#pragma once

#include <limits>

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

class CentreAxis {
 public:
  CentreAxis(const PosedPolytope& guest, const PosedPolytope& host)
      : guest_(guest),
        host_(host),
        host_centre_(host.pose.apply(host.body->centre)),
        between_centres_(guest.pose.apply(guest.body->centre) - host_centre_),
        axis_(between_centres_),
        rounding_(rounding(guest.body->origin_radius + host.body->origin_radius, norm_1(guest.pose.translation()),
                           norm_1(host.pose.translation()))),
        radii_(guest.body->radius + host.body->radius),
        inflation_radius_(guest.body->inflation_radius + host.body->inflation_radius) {}

  // From the host to the guest, in the world.
  Vec3 direction() const { return axis_; }

  // Turns the axis to where the bodies would face each other if they were ellipsoids. Round bodies already do so along
  // the axis, and small ones are tested faster than turned.
  void turn() {
    if (guest_.body->inner.points.size() + host_.body->inner.points.size() <= kFewVertices) return;
    const EquivalentEllipsoid &guest = guest_.body->ellipsoid, &host = host_.body->ellipsoid;
    if ((guest.is_round && host.is_round) || !guest.exists || !host.exists) return;
    const Vec3 u = direction_between(guest, guest_.pose, host, host_.pose);
    if (norm_1(u) > 0 && norm_1(u) < 4) axis_ = u;  // a guess, scaled to a largest entry of 1; may be NaN
  }

  bool has_inflation_radius() const { return inflation_radius_ > 0; }

  // Approximately the guest's extreme vertex towards the host.
  std::int32_t nearly_lowest(PairCounters& counters) const {
    ++counters.guest_queries;
    return extreme_at_top(guest_.body->inner, -guest_.pose.rotate_back(axis_), counters.queries);
  }

  // Whether the balls around the centres are apart.
  bool separates_balls() const {
    const double room = room_of_balls(radii_ + inflation_radius_, rounding_);
    return dot(between_centres_, between_centres_) > room * room;
  }

  // The same in lanes: balls are apart if their centres are further apart than this. `radii`: all four; `rounding`: of
  // both bodies' origin radii and both poses' translations.
  template <class Number>
  static Number room_of_balls(double radii, Number rounding) {
    return radii * (1 + kSlack) + rounding;
  }
  template <class Number>
  static Number rounding(double origin_radii, Number guest_translation, Number host_translation) {
    return kRounding * (origin_radii + guest_translation + host_translation) + kTrustedLength;
  }

  // A plane perpendicular to a direction from the host, in the host's frame, that touches the host's ball: q·x <= 1
  // over the host. A point has no such plane; it has no polar either, so none is cached.
  Vec3 touching_ball(Vec3 direction) const {
    return 1 / (host_.body->radius * norm(direction) * (1 + kSlack)) * host_.pose.rotate_back(direction);
  }

  // The answer that a plane perpendicular to the axis separates. `scaled`, for caching: to q·x <= 1 over the host.
  Certificate separated(bool scaled) const;

  // Decides by the centres and by the extreme vertices along the axis: a plane perpendicular to it separates the
  // bodies, or they are within the inflation radius. `lowest` becomes the guest's extreme vertex towards the host.
  Certificate decide(bool scaled, std::int32_t* lowest, PairCounters& counters) const;

 private:
  static constexpr std::size_t kFewVertices = 32;  // of both (measured)

  // Bodies are off rigid by at most 3.6e-6, so radii and inflation radii grow by half of that. The normal that is
  // handed on, M_R M_Rᵀ times the axis, is off by 3.6e-6 of its length, which moves products with differences of points
  // in proportion.
  static constexpr double kSlack = 1e-5;
  // Posing a centre or vertex errs by 7u of |coordinates| + |translation|. Turning a direction into a body's frame and
  // scanning along it errs by 20u of the reach. A difference and its product with the axis err by 6u: below 40u in all.
  // Lengths of balls, planes and inflation radii are trusted only above kTrustedLength, so it is part of the rounding.
  static constexpr double kRounding = 64 * 0x1p-53;

  const PosedPolytope &guest_, &host_;
  Vec3 host_centre_, between_centres_, axis_;
  double rounding_, radii_, inflation_radius_;

  // The rounding allowed along the axis, times its length. An axis too short for its length to be trusted separates
  // nothing.
  double room() const {
    const double length = norm(axis_);
    if (!(length > kTrustedLength)) return std::numeric_limits<double>::infinity();
    return length * (inflation_radius_ * (1 + kSlack) + kSlack * (norm(between_centres_) + radii_) + rounding_);
  }

  bool is_within_inflation_radius(Vec3 between) const {
    const double most = inflation_radius_ * (1 - kSlack) - rounding_;
    return most > kTrustedLength && dot(between, between) < most * most;
  }
  Certificate shared(Vec3 on_host, Vec3 between) const;
};

}  // namespace plannercheck
