// A part of a set, or a triangle of a solid, as a body for the tests of pairs: one object is filled again for each
// part.
//
// In: corners and a radius. Out: a Polytope that holds all that a test asks of A: vertices, their scan, and
// bounds. It has no polar and no faces, so that filling it takes no longer than a test.
#pragma once

#include "bodies/part_set.hpp"
#include "bodies/polytope.hpp"

namespace plannercheck {

class PartBody {
 public:
  // The points within `more` of the part. There is at least one corner.
  void fill(const PartShape& part, double more);
  // It has no inner shapes: those of a Polytope are found once, which is not enough for one that is filled again.
  const Polytope& body() const { return body_; }
  // In the body but for the rounding of its centre; the inflation radius is not counted.
  InnerBall inner_ball() const { return {body_.centre, 0}; }

 private:
  Polytope body_;

  void fill_point(Vec3 point, double radius);
};

// The part as a body with all that belongs to one.
Polytope polytope_of(const PartShape& part, double more);

}  // namespace plannercheck
