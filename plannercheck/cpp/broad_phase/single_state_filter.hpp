// Which bounding balls of one state meet each other and the boxes around obstacles. Its lanes run over bodies, for
// single states, which would leave lanes over states empty.
//
// In: posed links of one state; balls around bodies on links; boxes. Out: the pairs that may
// touch, by the same comparisons as in lanes over states. Immutable; the workspace of posed balls is the caller's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "broad_phase/bounding_sphere.hpp"
#include "broad_phase/obstacle_tree.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"
#include "robots/pose_columns.hpp"

namespace plannercheck {

class SingleStateFilter {
 public:
  // A pair of a ball with another one, or with a box.
  struct Partner {
    std::size_t ball, other;
    std::int32_t pair;
  };

  SingleStateFilter() = default;
  // `slices`: by ball, those that hold the body in its place, or none.
  SingleStateFilter(std::vector<BoundingBall> balls, const std::vector<std::vector<BoundingBall>>& slices,
                    const std::vector<WorldBox>& boxes, const std::vector<Partner>& balls_with_balls,
                    const std::vector<Partner>& balls_with_boxes);

  // Eight posed balls.
  struct Posed {
    Floats x, y, z, radius, limit;  // see `far_beyond` for the last
  };
  struct Workspace {
    std::vector<Posed> posed;
    std::vector<std::uint8_t> near;  // a bit for each of eight partners, by test
  };
  Workspace new_workspace() const {
    return {std::vector<Posed>(sizes_.size()), std::vector<std::uint8_t>(tests_room())};
  }

  void pose(const PoseColumns* links, Workspace& workspace) const;

  struct Ball {
    float x, y, z, radius, limit;
  };
  static Ball ball(std::size_t index, const Workspace& workspace) { return ball(index, workspace.posed.data()); }

  // Calls found(pair) for all pairs that may touch.
  template <class Found>
  void find(Workspace& workspace, Found found) const;

 private:
  static Ball ball(std::size_t index, const Posed* posed) {
    const Posed& eight = posed[index / kFloats];
    const std::size_t lane = index % kFloats;
    return {eight.x[lane], eight.y[lane], eight.z[lane], eight.radius[lane], eight.limit[lane]};
  }
  static Floats everywhere(float c) { return Floats{c, c, c, c, c, c, c, c}; }

  // One ball against eight partners, with at least one of which its body has a pair.
  struct Test {
    std::size_t ball, eight;
    std::uint8_t paired;                      // a bit for each partner with which it has one
    std::array<std::int32_t, kFloats> pairs;  // by partner
  };

  // The same of another slice of a body: what it is near is added to what that test of the first slice has found.
  struct SliceTest {
    Test test;
    std::size_t slot;
  };

  struct Sizes {
    Floats radius, room;
  };
  struct Boxes {
    std::array<Floats, 3> low, high;
  };

  static std::size_t eights_of(std::size_t count) { return (count + kFloats - 1) / kFloats; }
  static std::vector<Test> tests(const std::vector<Partner>& partners, std::size_t balls, std::size_t others);
  // Tests are looked at by eights.
  std::size_t tests_room() const { return eights_of(ball_tests_.size() + box_tests_.size()) * kFloats; }
  void slice(const std::vector<std::vector<BoundingBall>>& slices);
  static std::uint8_t near_balls(const Test& test, const Posed* posed);

  std::vector<BoundingBall> balls_;
  std::vector<Sizes> sizes_;  // of eight balls
  std::vector<Boxes> boxes_;  // of eight obstacles
  std::vector<Test> ball_tests_, box_tests_;
  std::vector<SliceTest> slice_tests_;
};

inline std::uint8_t SingleStateFilter::near_balls(const Test& test, const Posed* posed) {
  const Ball own = ball(test.ball, posed);
  const Posed& others = posed[test.eight];
  const Floats x = others.x - own.x, y = others.y - own.y, z = others.z - own.z;
  const unsigned far = bits_above((x * x + y * y) + z * z, far_beyond(others.radius + own.radius));
  return static_cast<std::uint8_t>(~far & test.paired);
}

// All tests first, without a branch: which partners are near is hard to predict.
template <class Found>
void SingleStateFilter::find(Workspace& w, Found found) const {
  const Posed* const posed = w.posed.data();  // bytes are written, which might be these pointers' own
  const Boxes* const eights = boxes_.data();
  std::uint8_t* near = w.near.data();
  for (const Test& test : ball_tests_) *near++ = near_balls(test, posed);
  for (const SliceTest& test : slice_tests_) {
    std::uint8_t& slot = w.near[test.slot];
    slot = static_cast<std::uint8_t>(slot | near_balls(test.test, posed));
  }
  for (const Test& test : box_tests_) {
    const Ball own = ball(test.ball, posed);
    const Boxes& boxes = eights[test.eight];
    const Floats x = beyond(everywhere(own.x), boxes.low[0], boxes.high[0]);
    const Floats y = beyond(everywhere(own.y), boxes.low[1], boxes.high[1]);
    const Floats z = beyond(everywhere(own.z), boxes.low[2], boxes.high[2]);
    const unsigned far = bits_above((x * x + y * y) + z * z, everywhere(own.limit));
    *near++ = static_cast<std::uint8_t>(~far & test.paired);
  }
  for (std::size_t first = 0; first < w.near.size(); first += kFloats) {
    std::uint64_t eight;
    std::memcpy(&eight, &w.near[first], sizeof eight);
    for (; eight != 0; eight &= eight - 1) {
      const auto bit = static_cast<std::size_t>(__builtin_ctzll(eight)), k = first + bit / kFloats;
      const Test& test = k < ball_tests_.size() ? ball_tests_[k] : box_tests_[k - ball_tests_.size()];
      found(test.pairs[bit % kFloats]);
    }
  }
}

}  // namespace plannercheck
