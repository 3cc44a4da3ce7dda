// Which bounding balls of one state meet each other and the boxes around obstacles. Its lanes run over bodies, for
// single states, which would leave lanes over states empty.
//
// In: posed links of a block, of which one state counts; balls around bodies on links; boxes. Out: the pairs that may
// touch, by the same comparisons as in lanes over states. Immutable; the workspace of posed balls is the caller's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/obstacle_tree.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

class SingleStateFilter {
 public:
  // A pair of a ball with another one, or with a box.
  struct Partner {
    std::int32_t ball, other, pair;
  };

  SingleStateFilter() = default;
  // `links`: how many the robot has.
  SingleStateFilter(std::vector<BoundingBall> balls, std::size_t links, const std::vector<WorldBox>& boxes,
                    const std::vector<Partner>& balls_with_balls, const std::vector<Partner>& balls_with_boxes);

  // Eight posed balls.
  struct Posed {
    Floats x, y, z, radius;
  };
  typedef std::vector<Posed> Workspace;
  Workspace new_workspace() const { return Workspace(eights_of(balls_.size())); }

  void pose(const Lanes* links, std::size_t state, Workspace& posed) const;

  struct Ball {
    float x, y, z, radius;
  };
  static Ball ball(std::size_t index, const Workspace& posed);

  // Calls found(pair) for all pairs that may touch.
  template <class Found>
  void find(const Workspace& posed, Found found) const;

 private:
  // Eight partners, and a bit for each with which the ball has a pair.
  struct Eight {
    std::size_t index;
    unsigned paired;
  };

  // All partners of one ball.
  struct Row {
    std::size_t ball;
    std::vector<Eight> eights;        // those with at least one pair
    std::vector<std::int32_t> pairs;  // by partner
  };

  struct Sizes {
    Floats radius, room;
  };
  struct Boxes {
    std::array<Floats, 3> low, high;
  };

  static std::size_t eights_of(std::size_t count) { return (count + kFloats - 1) / kFloats; }
  static std::vector<Row> rows(const std::vector<Partner>& partners, std::size_t balls, std::size_t others);

  // Calls found(pair) for the partners whose bit near(eight) sets.
  template <class Near, class Found>
  static void find_in(const Row& row, Near near, Found found);

  std::vector<BoundingBall> balls_;
  std::size_t links_ = 0;
  std::vector<Sizes> sizes_;  // of eight balls
  std::vector<Boxes> boxes_;  // of eight obstacles
  std::vector<Row> ball_rows_, box_rows_;
};

template <class Near, class Found>
void SingleStateFilter::find_in(const Row& row, Near near, Found found) {
  for (const Eight& eight : row.eights) {
    for (unsigned left = near(eight.index) & eight.paired; left != 0; left &= left - 1) {
      found(row.pairs[eight.index * kFloats + static_cast<std::size_t>(__builtin_ctz(left))]);
    }
  }
}

template <class Found>
void SingleStateFilter::find(const Workspace& posed, Found found) const {
  for (const Row& row : ball_rows_) {
    const Ball own = ball(row.ball, posed);
    find_in(
        row,
        [&](std::size_t k) {
          const Posed& others = posed[k];
          const Floats x = others.x - own.x, y = others.y - own.y, z = others.z - own.z;
          return ~float_bits((x * x + y * y) + z * z > far_beyond(others.radius + own.radius));
        },
        found);
  }
  for (const Row& row : box_rows_) {
    const Ball own = ball(row.ball, posed);
    find_in(
        row,
        [&](std::size_t k) {
          const Boxes& boxes = boxes_[k];
          const Floats x = beyond(Floats{} + own.x, boxes.low[0], boxes.high[0]);
          const Floats y = beyond(Floats{} + own.y, boxes.low[1], boxes.high[1]);
          const Floats z = beyond(Floats{} + own.z, boxes.low[2], boxes.high[2]);
          return ~float_bits((x * x + y * y) + z * z > far_beyond(own.radius));
        },
        found);
  }
}

}  // namespace plannercheck
