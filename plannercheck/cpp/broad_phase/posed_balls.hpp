// Bounding balls in the states of a block, and boxes around some of them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "broad_phase/float_boxes.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

// A ball in each state; its radius covers the rounding of its posing.
struct PosedBalls {
  StateFloats x, y, z, radius;

  // The states in which it meets another one, a bit each. `limit`: what squared distances have to exceed.
  unsigned near(const PosedBalls& other, StateFloats limit) const {
    const StateFloats dx = x - other.x, dy = y - other.y, dz = z - other.z;
    return ~bits_above(dot_of(dx, dy, dz, dx, dy, dz), limit);
  }
  unsigned near(const PosedBalls& other) const { return near(other, far_beyond(radius + other.radius)); }
};

// A box in every lane.
struct BoxInFloats {
  std::array<StateFloats, 3> low, high;

  // The boxes that it meets, a bit each.
  unsigned met(const BoxLanes<StateFloats>& boxes) const {
    BitsOfAny<StateFloats> apart;
    for (std::size_t i = 0; i < 3; ++i) {
      apart.add_above(low[i], boxes.high[i]);
      apart.add_above(boxes.low[i], high[i]);
    }
    return ~apart.bits() & boxes.present;
  }
};

// A box in each state.
struct BoxInStates {
  std::array<StateFloats, 3> low, high;

  // The states in which it meets a box, which stands still or is one in each state, a bit each.
  template <class Box>
  unsigned met(const Box& box) const {
    BitsOfAny<StateFloats> apart;
    for (std::size_t i = 0; i < 3; ++i) {
      apart.add_above(low[i], filled<StateFloats>(box.high[i]));
      apart.add_above(filled<StateFloats>(box.low[i]), high[i]);
    }
    return ~apart.bits();
  }

  BoxInFloats around_all() const {
    BoxInFloats out;
    for (std::size_t i = 0; i < 3; ++i)
      out.low[i] = smallest_everywhere(low[i]), out.high[i] = -smallest_everywhere(-high[i]);
    return out;
  }
};

// Around some balls in each state. Their radii have room for the rounding of one more sum.
inline BoxInStates box_around(const PosedBalls* balls, std::size_t count) {
  const StateFloats infinity = StateFloats{} + __builtin_inff();
  BoxInStates out{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  StateFloats total{};
  for (std::size_t m = 0; m < count; ++m) {
    const std::array<StateFloats, 3> centre{balls[m].x, balls[m].y, balls[m].z};
    for (std::size_t i = 0; i < 3; ++i) {
      out.low[i] = smaller(out.low[i], centre[i] - balls[m].radius);
      out.high[i] = larger(out.high[i], centre[i] + balls[m].radius);
    }
    total += balls[m].radius;
  }
  // A ball whose centre is infinite or NaN has such a radius, too, and may be anywhere.
  const StateMask known = total < infinity;
  for (std::size_t i = 0; i < 3; ++i) {
    out.low[i] = known ? out.low[i] : -infinity;
    out.high[i] = known ? out.high[i] : infinity;
  }
  return out;
}

}  // namespace plannercheck
