// Which bounding balls may touch half-spaces, which no box or tree holds: by the heights of their centres, in floats.
//
// In: static half-spaces, posed balls of a block of states. Out: the states in which a pair is apart; none for NaN.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/filter.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/posed_balls.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class PlaneFilter {
 public:
  // A half-space that a ball, by its number, has a pair with.
  struct Row {
    std::int32_t pair;
    std::size_t ball;
    std::array<float, 3> normal;
    float top;  // how high the half-space reaches along the normal, rounded upwards
  };
  void add(std::int32_t pair, std::size_t ball, const GeometryObject& half_space);
  const std::vector<Row>& rows() const { return rows_; }

  static Masks look(const Row& row, const PosedBalls& ball) {
    const StateFloats size = (absolute(ball.x) + absolute(ball.y)) + absolute(ball.z);
    const StateFloats height = (ball.x * row.normal[0] + ball.y * row.normal[1]) + ball.z * row.normal[2];
    return {.apart = bits_above(height, (ball.radius + size * kPlaneError) + row.top)};
  }

 private:
  // Floats err by u = 2^-24. A normal's entries err by u, the height by 5u more of |centre|_1, the sum of radius,
  // size and top by 3u of each; the radius has as much room itself.
  static constexpr float kPlaneError = 0x1p-20F;

  std::vector<Row> rows_;
};

}  // namespace plannercheck
