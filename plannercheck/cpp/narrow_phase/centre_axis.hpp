// The axis between the centres of two posed bodies: it separates most of those that are far apart, and joins round ones
// that are within each other's swell. Of long and flat bodies another one separates more: the axis may be turned to it.
#pragma once

#include <limits>

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

class CentreAxis {
 public:
  CentreAxis(const PosedBody& guest, const PosedBody& host)
      : guest_(guest),
        host_(host),
        host_centre_(host.pose.apply(host.body->centre)),
        between_centres_(guest.pose.apply(guest.body->centre) - host_centre_),
        axis_(between_centres_),
        rounding_(kRounding * (guest.body->reach + host.body->reach + norm_1(guest.pose.translation()) +
                               norm_1(host.pose.translation())) +
                  kTrustedLength),
        radii_(guest.body->radius + host.body->radius),
        swell_(guest.body->swell + host.body->swell) {}

  // From the host to the guest, in the world.
  Vec3 direction() const { return axis_; }

  // To where the bodies would face each other if they were ellipsoids; round ones do so along the axis, and the test of
  // small ones takes less time than the turn.
  void turn() {
    if (guest_.body->inner.points.size() + host_.body->inner.points.size() <= kFewVertices) return;
    const AlikeEllipsoid &guest = guest_.body->alike, &host = host_.body->alike;
    if ((guest.is_round && host.is_round) || !guest.exists || !host.exists) return;
    const Vec3 u = direction_between(guest, guest_.pose, host, host_.pose);
    if (norm_1(u) > 0 && norm_1(u) < 4) axis_ = u;  // a guess of numbers, whose largest is 1
  }

  bool has_swell() const { return swell_ > 0; }

  // About the guest's extreme vertex towards the host.
  std::int32_t nearly_lowest(PairCounters& counters) const {
    ++counters.guest_queries;
    return extreme_at_top(guest_.body->inner, -guest_.pose.rotate_back(axis_), counters.queries);
  }

  // Whether the balls around the centres are apart.
  bool separates_balls() const {
    const double room = (radii_ + swell_) * (1 + kSlack) + rounding_;
    return dot(between_centres_, between_centres_) > room * room;
  }

  // A plane at right angles to a direction from the host, in the host's frame, that touches the host's ball: q·x <= 1
  // over the host. A point has none, but no polar either, so no plane of it is cached.
  Vec3 touching_ball(Vec3 direction) const {
    return 1 / (host_.body->radius * norm(direction) * (1 + kSlack)) * host_.pose.rotate_back(direction);
  }

  // Separated by a plane at right angles to the axis. Only a plane that will be cached has q scaled: q·x <= 1 over the
  // host.
  Certificate separated(bool scaled) const;

  // Whether the centres are within the swell, and the point between them.
  bool centres_share() const { return is_within_swell(between_centres_); }
  Certificate shared_by_centres() const { return shared(host_centre_, between_centres_); }

  // The directions of the vertices that face the other body, each in its own body's frame.
  Vec3 towards_host() const { return -guest_.pose.rotate_back(axis_); }
  Vec3 towards_guest() const { return host_.pose.rotate_back(axis_); }

  // Whether the guest's such vertex is beyond the host's centre, else the axis decides nothing; then, by both vertices.
  bool is_beyond_centre(Vec3 of_guest) const { return dot(axis_, guest_.pose.apply(of_guest) - host_centre_) > room(); }
  Certificate decide(Vec3 of_guest, Vec3 of_host, bool scaled) const;

  // Whether a plane at right angles to another direction from the host to the guest separates the bodies. `defect`: at
  // least how far the host's pose is off rigid.
  bool separates(Vec3 direction, double defect, PairCounters& counters) const;

  // By the centres, and the vertices that are extreme along the axis: whether a plane at right angles to it separates
  // the bodies, or they are within the swell. `lowest` becomes the guest's extreme vertex towards the host.
  Certificate decide(bool scaled, std::int32_t* lowest, PairCounters& counters) const;

 private:
  static constexpr std::size_t kFewVertices = 32;  // of both (measured)

  // Bodies are off rigid by 3.6e-6 at most: radii and swells grow by half of that, and the normal handed on, M_R M_Rᵀ
  // times the axis, is off by as much of its length, which moves differences of points by that much of theirs.
  static constexpr double kSlack = 1e-5;
  // Posing a centre or vertex errs by 7u of |coordinates| + |translation|, a direction turned into a body's frame and
  // the scan along it by 20u of the reach, a difference and its product with the axis by 6u: below 40u in all.
  // Balls, planes and swells are trusted to tell lengths above kTrustedLength only, so that it is a part of what
  // rounding may be.
  static constexpr double kRounding = 64 * 0x1p-53;

  const PosedBody &guest_, &host_;
  Vec3 host_centre_, between_centres_, axis_;
  double rounding_, radii_, swell_;

  // Along the axis, or a direction that turns by no more than `slack` on its way through the host's frame, times its
  // length; a direction so short that its length is not trusted separates nothing.
  double room() const { return room(axis_, kSlack); }
  double room(Vec3 direction, double slack) const {
    const double length = norm(direction);
    if (!(length > kTrustedLength)) return std::numeric_limits<double>::infinity();
    return length * (swell_ * (1 + slack) + slack * (norm(between_centres_) + radii_) + rounding_);
  }

  bool is_within_swell(Vec3 between) const {
    const double most = swell_ * (1 - kSlack) - rounding_;
    return most > kTrustedLength && dot(between, between) < most * most;
  }
  Certificate shared(Vec3 on_host, Vec3 between) const;
};

}  // namespace plannercheck
