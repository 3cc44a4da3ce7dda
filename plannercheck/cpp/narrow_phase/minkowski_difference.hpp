// Vertices of the Minkowski difference conv(A) − conv(B) of two posed bodies, without their inflation radii.
//
// In: two posed bodies and directions of the world. Out: the difference that is lowest along a direction, by one
// extreme vertex of each body, and bounds of its rounding. Distances and depths are those of the origin from this
// difference.
#pragma once

#include "narrow_phase/pair_frame.hpp"
#include "narrow_phase/support.hpp"

namespace plannercheck {

struct DifferenceCorner {
  Vec3 difference, body_a;  // A vertex − B vertex relative to both translations; A vertex in the world
  std::int32_t vertex_a, vertex_b;
};

class MinkowskiDifference {
 public:
  MinkowskiDifference(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters)
      : body_a_(body_a),
        body_b_(body_b),
        counters_(counters),
        shift_(body_a.pose.translation() - body_b.pose.translation()),
        size_(body_a.body->origin_radius + body_b.body->origin_radius + norm_1(shift_)) {}

  const PosedPolytope& body_a() const { return body_a_; }
  const PosedPolytope& body_b() const { return body_b_; }

  // No difference is longer, up to rounding.
  double size() const { return size_; }
  // The error of a difference as a vector, and of the lowest height along a direction whose length is 1 up to rounding.
  double difference_error() const { return kDifference * size_ + kDenormalError; }
  double support_error() const { return kSupport * size_ + kDenormalError; }

  DifferenceCorner lowest_along(Vec3 d) const {
    ++counters_.queries_a, ++counters_.queries_b;
    const std::int32_t p = extreme(body_a_.body->inner, -body_a_.pose.rotate_back(d), counters_.queries);
    const std::int32_t r = extreme(body_b_.body->inner, body_b_.pose.rotate_back(d), counters_.queries);
    return corner(p, r);
  }

  DifferenceCorner corner(std::int32_t p, std::int32_t r) const {
    const Vec3 turned = body_a_.pose.rotate(body_a_.body->inner.points[at(p)]);
    return {(turned - body_b_.pose.rotate(body_b_.body->inner.points[at(r)])) + shift_,
            turned + body_a_.pose.translation(), p, r};
  }

 private:
  // Both bounds are multiples of the sum of the sizes r_P + r_R + |w|, w = t_P − t_R;
  // tests/error_bounds/minkowski_difference checks them.
  //
  // kDifference: fl(M_P p) − fl(M_R r) + fl(t_P − t_R) errs by 5.2u (r_P + r_R) in the products, u |w| in the
  // translations and 2u of everything in the sums: below 7.2u.
  //
  // kSupport: a direction d of the world errs by 5.2u |d| when turned into a body's frame. This moves both the vertex
  // found and the one lowest along d itself: 10.4u |d| r. A scan in doubles compares two rounded products, 3u |d| r
  // each by Cauchy-Schwarz (kScanError, by |d|_1, would be 7u). The difference errs as above, evaluating d·w by 3u |d|
  // |w|: 26.6u in all. The length of d is 1 up to 4.5u, and heights are at most the sum of the sizes, so distances need
  // that much more: 31.1u. Inflation radii lose 3u to rounding, of the 4u that kInflationAlong gives them.
  //
  // Where lengths are so small that products underflow, both err by at most kDenormalError more: nine products a body
  // and three of the height, by 2^-1075 each, times entries of the direction.
  static constexpr double kDifference = 12 * 0x1p-53, kSupport = 32 * 0x1p-53;

  const PosedPolytope &body_a_, &body_b_;
  PairCounters& counters_;
  Vec3 shift_;
  double size_;
};

}  // namespace plannercheck
