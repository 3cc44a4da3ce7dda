// The axis between the centres of two posed bodies, which separates most of those that are far apart.
#pragma once

#include "pair.hpp"

namespace plannercheck {

class CentreAxis {
 public:
  CentreAxis(const PosedBody& guest, const PosedBody& host)
      : guest_(guest),
        host_(host),
        axis_(guest.pose.apply(guest.body->centre) - host.pose.apply(host.body->centre)),
        rounding_(kRounding * (guest.body->reach + host.body->reach + norm_1(guest.pose.translation()) +
                               norm_1(host.pose.translation()))),
        radii_(guest.body->radius + host.body->radius),
        swell_(guest.body->swell + host.body->swell) {}

  // From the host to the guest, in the world.
  Vec3 direction() const { return axis_; }

  // Whether the balls around the centres are apart.
  bool separates_balls() const {
    const double room = (radii_ + swell_) * (1 + kSlack) + rounding_;
    return dot(axis_, axis_) > room * room;
  }

  // Whether a plane at right angles to the axis separates the bodies. `lowest` becomes the guest's extreme vertex
  // towards the host.
  bool separates_bodies(std::int32_t* lowest, PairCounters& counters) const;

  // The certificate, once one of these says so. Only a plane that will be cached has q scaled: q·x <= 1 over the host.
  Certificate certificate(bool scaled) const;

 private:
  // Poses are off rigid by 1e-6 at most: radii and swells grow by as much, and the normal that is handed on, M_R M_Rᵀ
  // times the axis, is off by as much of its length, which moves differences of points by that much of theirs.
  static constexpr double kSlack = 1e-5;
  // Posing a centre or vertex errs by 7u of |coordinates| + |translation|, a direction turned into a body's frame and
  // the scan along it by 20u of the reach, a difference and its product with the axis by 6u: below 40u in all.
  static constexpr double kRounding = 64 * 0x1p-53;

  const PosedBody &guest_, &host_;
  Vec3 axis_;
  double rounding_, radii_, swell_;
};

}  // namespace plannercheck
