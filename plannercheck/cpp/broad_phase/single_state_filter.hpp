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
#include "broad_phase/float_boxes.hpp"
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
  static Ball ball(std::size_t index, const Workspace& workspace) {
    return ball_at(floats_of(workspace), place_of<Posed>(index));
  }

  // Calls found(pair) for all pairs that may touch.
  template <class Found>
  void find(Workspace& workspace, Found found) const;

 private:
  static Ball ball_at(const float* posed, std::uint32_t place) {
    const float* const own = posed + place;
    return {own[0], own[kFloats], own[2 * kFloats], own[3 * kFloats], own[4 * kFloats]};
  }
  static const float* floats_of(const Workspace& w) { return reinterpret_cast<const float*>(w.posed.data()); }

  // Where an item begins in an array of eights of items, in floats.
  template <class Eight>
  static std::uint32_t place_of(std::size_t item) {
    return static_cast<std::uint32_t>(item / kFloats * (sizeof(Eight) / sizeof(float)) + item % kFloats);
  }
  template <class Eight>
  static const Eight& eight_at(const float* floats, std::uint32_t place) {
    return *reinterpret_cast<const Eight*>(floats + place);
  }
  static Floats everywhere(float c) { return Floats{c, c, c, c, c, c, c, c}; }

  // One ball against eight partners, with at least one of which its body has a pair. Places are counted in floats, so
  // that nothing is computed to find them.
  struct Test {
    std::uint32_t own, eight;  // where the ball is in the posed ones, where the partners begin
    std::uint8_t paired;       // a bit for each partner with which it has a pair
  };

  // The same of another slice of a body: what it is near is added to what that test of the first slice has found.
  struct SliceTest {
    Test test;
    std::uint32_t slot;
  };

  using Pairs = std::array<std::int32_t, kFloats>;  // by partner

  struct Sizes {
    Floats radius, room;
  };

  // Tests of one kind.
  struct Tests {
    std::vector<Test> tests;
    std::vector<Pairs> pairs;  // of each
  };

  static std::size_t eights_of(std::size_t count) { return (count + kFloats - 1) / kFloats; }
  template <class Eight>
  static Tests tests(const std::vector<Partner>& partners, std::size_t balls, std::size_t others);
  // Tests are looked at by eights.
  std::size_t tests_room() const { return eights_of(ball_tests_.tests.size() + box_tests_.tests.size()) * kFloats; }
  void slice(const std::vector<std::vector<BoundingBall>>& slices);
  static std::uint8_t near_balls(const Test& test, const float* posed);
  static std::uint8_t near_boxes(const Test& test, const float* posed, const float* boxes);

  std::vector<BoundingBall> balls_;
  std::vector<Sizes> sizes_;  // of eight balls
  std::vector<EightBoxes> boxes_;
  Tests ball_tests_, box_tests_;
  std::vector<SliceTest> slice_tests_;
};

inline std::uint8_t SingleStateFilter::near_balls(const Test& test, const float* posed) {
  const Ball own = ball_at(posed, test.own);
  const Posed& others = eight_at<Posed>(posed, test.eight);
  const Floats x = others.x - own.x, y = others.y - own.y, z = others.z - own.z;
  const unsigned far = bits_above((x * x + y * y) + z * z, far_beyond(others.radius + own.radius));
  return static_cast<std::uint8_t>(~far & test.paired);
}

inline std::uint8_t SingleStateFilter::near_boxes(const Test& test, const float* posed, const float* boxes) {
  const Ball own = ball_at(posed, test.own);
  const EightBoxes& eight = eight_at<EightBoxes>(boxes, test.eight);
  const Floats x = beyond(everywhere(own.x), eight.low[0], eight.high[0]);
  const Floats y = beyond(everywhere(own.y), eight.low[1], eight.high[1]);
  const Floats z = beyond(everywhere(own.z), eight.low[2], eight.high[2]);
  const unsigned far = bits_above((x * x + y * y) + z * z, everywhere(own.limit));
  return static_cast<std::uint8_t>(~far & test.paired);
}

// All tests first, without a branch: which partners are near is hard to predict.
template <class Found>
void SingleStateFilter::find(Workspace& w, Found found) const {
  const float* const posed = floats_of(w);  // bytes are written, which might be these pointers' own
  const float* const boxes = reinterpret_cast<const float*>(boxes_.data());
  std::uint8_t* const near = w.near.data();
  std::uint8_t* next = near;
  for (const Test& test : ball_tests_.tests) *next++ = near_balls(test, posed);
  for (const SliceTest& test : slice_tests_) {
    near[test.slot] = static_cast<std::uint8_t>(near[test.slot] | near_balls(test.test, posed));
  }
  for (const Test& test : box_tests_.tests) *next++ = near_boxes(test, posed, boxes);
  const std::size_t of_balls = ball_tests_.tests.size(), room = w.near.size();
  for (std::size_t first = 0; first < room; first += kFloats) {
    std::uint64_t eight;
    std::memcpy(&eight, near + first, sizeof eight);
    for (; eight != 0; eight &= eight - 1) {
      const auto bit = static_cast<std::size_t>(__builtin_ctzll(eight)), k = first + bit / kFloats;
      const Pairs& pairs = k < of_balls ? ball_tests_.pairs[k] : box_tests_.pairs[k - of_balls];
      found(pairs[bit % kFloats]);
    }
  }
}

}  // namespace plannercheck
