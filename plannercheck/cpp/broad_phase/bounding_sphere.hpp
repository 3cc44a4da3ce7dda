// A ball around a body on a link, in floats, and the radius that the posed ball needs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/float_pose_error.hpp"
#include "broad_phase/geometry_object.hpp"
#include "math/simd.hpp"

namespace plannercheck {

struct BoundingBall {
  std::int32_t link;
  std::array<float, 3> centre;  // in the link's frame
  float radius;
  float room;  // rounding of posing, besides that of the posed centre

  // Radius of the posed ball: it holds the body in spite of all rounding, including that of this sum, and of an error
  // of its link's pose.
  template <FloatVector Numbers>
  Numbers radius_at(Numbers x, Numbers y, Numbers z, PoseError error) const {
    return radius_at(x, y, z, Numbers{} + radius, Numbers{} + (room + error.of_point(reach())));
  }
  template <FloatVector Numbers>
  Numbers radius_at(Numbers x, Numbers y, Numbers z) const {
    return radius_at(x, y, z, PoseError{});
  }
  template <FloatVector Numbers>
  static Numbers radius_at(Numbers x, Numbers y, Numbers z, Numbers radius, Numbers room);

  // A radius for all states whose poses have at most such an error (proof in bounding_sphere.cpp).
  float radius_anywhere(PoseError error) const;

  // Floats err by u = 2^-24. Posing a ball's centre c from rounded numbers takes three products and sums and errs by at
  // most 6u of the posed centre and 17u of |c|, in |.|_1. This also covers posing vertices in doubles and computing the
  // bound.
  static constexpr double kCentreError = 0x1p-19;

 private:
  // No point of the body is further from its link's origin (bounding_sphere.cpp).
  float reach() const { return room * static_cast<float>(1 / kCentreError); }
};

template <FloatVector Numbers>
Numbers BoundingBall::radius_at(Numbers x, Numbers y, Numbers z, Numbers radius, Numbers room) {
  constexpr auto kError = static_cast<float>(kCentreError);
  const Numbers size = (absolute(x) + absolute(y)) + absolute(z);
  return ((size * kError + room) + radius) * (1 + kError) + 1e-37F;
}

BoundingBall bounding_ball(const GeometryObject& object);

// Two or three balls that hold the body together, where one would be far larger; else none.
std::vector<BoundingBall> slice_balls(const GeometryObject& object);

}  // namespace plannercheck
