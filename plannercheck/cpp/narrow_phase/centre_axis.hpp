// The axis between the centres of two posed bodies. It separates most bodies that are far apart, and shows that round
// bodies are within each other's inflation radius. A turned axis separates long and flat bodies more often.
#pragma once

#include <limits>

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

class CentreAxis {
 public:
  CentreAxis(const PosedPolytope& body_a, const PosedPolytope& body_b)
      : body_a_(body_a),
        body_b_(body_b),
        centre_b_(body_b.pose.apply(body_b.body->centre)),
        between_centres_(body_a.pose.apply(body_a.body->centre) - centre_b_),
        axis_(between_centres_),
        rounding_(rounding(body_a.body->origin_radius + body_b.body->origin_radius, norm_1(body_a.pose.translation()),
                           norm_1(body_b.pose.translation()))),
        radii_(body_a.body->radius + body_b.body->radius),
        inflation_radius_(body_a.body->inflation_radius + body_b.body->inflation_radius) {}

  // From B to A, in the world.
  Vec3 direction() const { return axis_; }

  // Turns the axis to where the bodies would face each other if they were ellipsoids. Round bodies face each other
  // along the axis already; bodies of few vertices are tested faster than turned.
  void turn() {
    if (body_a_.body->inner.points.size() + body_b_.body->inner.points.size() <= kFewVertices) return;
    const EquivalentEllipsoid &body_a = body_a_.body->ellipsoid, &body_b = body_b_.body->ellipsoid;
    if ((body_a.is_round && body_b.is_round) || !body_a.exists || !body_b.exists) return;
    const Vec3 u = direction_between(body_a, body_a_.pose, body_b, body_b_.pose);
    if (norm_1(u) > 0 && norm_1(u) < 4) axis_ = u;  // a guess, scaled to a largest entry of 1; may be NaN
  }

  bool has_inflation_radius() const { return inflation_radius_ > 0; }

  // Approximately A's extreme vertex towards B.
  std::int32_t nearly_lowest(PairCounters& counters) const {
    ++counters.queries_a;
    return extreme_at_top(body_a_.body->inner, -body_a_.pose.rotate_back(axis_), counters.queries);
  }

  // Whether the balls around the centres are apart.
  bool separates_balls() const {
    const double room = room_of_balls(radii_ + inflation_radius_, rounding_);
    return dot(between_centres_, between_centres_) > room * room;
  }

  // As separates_balls, for lanes: balls are apart if their centres are further apart than this. `radii`: the sum of
  // all four; `rounding`: see below.
  template <class Number>
  static Number room_of_balls(double radii, Number rounding) {
    return radii * (1 + kSlack) + rounding;
  }
  template <class Number>
  static Number rounding(double origin_radii, Number translation_a, Number translation_b) {
    return kRounding * (origin_radii + translation_a + translation_b) + kTrustedLength;
  }

  // A plane perpendicular to a direction from B, in B's frame, that touches B's ball: q·x <= 1
  // over B. A point has no such plane; it has no polar either, so none is cached.
  Vec3 touching_ball(Vec3 direction) const {
    return 1 / (body_b_.body->radius * norm(direction) * (1 + kSlack)) * body_b_.pose.rotate_back(direction);
  }

  // The answer that a plane perpendicular to the axis separates. `scaled`, for caching: to q·x <= 1 over B.
  Certificate separated(bool scaled) const;

  // Decides by the centres and by the extreme vertices along the axis: a plane perpendicular to it separates the
  // bodies, or they are within the inflation radius. `lowest` becomes A's extreme vertex towards B.
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

  const PosedPolytope &body_a_, &body_b_;
  Vec3 centre_b_, between_centres_, axis_;
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
  Certificate shared(Vec3 on_body_b, Vec3 between) const;
};

}  // namespace plannercheck
