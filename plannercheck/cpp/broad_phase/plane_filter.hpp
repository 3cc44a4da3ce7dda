// Which bounding balls may reach into half-spaces, which no box or tree holds: by the heights of their centres, in
// floats.
//
// In: half-spaces that stand still, posed balls of a block of states, or of one. Out: the pairs that may touch, and in
// which of these states. In doubt, and for centres that are no numbers, a pair may touch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/geometry_object.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class PlaneFilter {
 public:
  // A pair of a ball, by its number, with a half-space.
  void add(std::int32_t pair, std::size_t ball, const GeometryObject& half_space);
  std::size_t size() const { return planes_.size(); }

  // Calls found(pair, states) where some of the states are left. `posed(ball)`: its x, y, z and radius as StateFloats.
  template <class Posed, class Found>
  void find(Posed posed, unsigned states, Found found) const {
    for (const Plane& plane : planes_) {
      const auto& ball = posed(plane.ball);
      const StateFloats size = (absolute(ball.x) + absolute(ball.y)) + absolute(ball.z);
      const StateFloats height = (ball.x * plane.normal[0] + ball.y * plane.normal[1]) + ball.z * plane.normal[2];
      const unsigned near = ~bits_above(height, (ball.radius + size * kPlaneError) + plane.top) & states;
      if (near != 0) found(plane.pair, near);
    }
  }

 private:
  // Floats err by u = 2^-24. A normal's entries err by u, the height by 5u more of |centre|_1, the sum of radius,
  // size and top by 3u of each; the radius has as much room itself.
  static constexpr float kPlaneError = 0x1p-20F;

  struct Plane {
    std::int32_t pair;
    std::size_t ball;
    std::array<float, 3> normal;
    float top;  // how high the half-space reaches along the normal, rounded upwards
  };
  std::vector<Plane> planes_;
};

}  // namespace plannercheck
