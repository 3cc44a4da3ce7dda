// Which bounding balls of one state meet each other and the boxes around obstacles, in lanes over pairs: a single state
// would leave lanes over states empty.
//
// In: posed links of one state; balls around bodies on links; boxes. Out: the pairs that may touch, by the same
// comparisons as in lanes over states. Idea: eight balls are posed side by side. A test of balls, or of boxes, takes
// any eight pairs whose balls are from the same two groups of eight; lanes over the few partners of one ball would be
// half empty. There are eight lanes on AVX-512, too: wider vectors slow down the next hundred cycles by more than they
// save. Immutable; the workspace of posed balls is the caller's.
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
                    const std::vector<Box>& boxes, const std::vector<Partner>& balls_with_balls,
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
    const Posed& eight = workspace.posed[index / kFloats];
    const std::size_t lane = index % kFloats;
    return {eight.x[lane], eight.y[lane], eight.z[lane], eight.radius[lane], eight.limit[lane]};
  }

  // Calls found(pair) for all pairs that may touch.
  template <class Found>
  void find(Workspace& workspace, Found found) const;

 private:
  // Some of eight posed balls, one in each lane.
  struct Picked {
    FloatMask places;  // among the eight
    std::size_t eight;
  };

  struct BallTest {
    Picked balls, others;
    std::uint8_t pairs;  // a bit for each lane that holds a pair
  };

  // A test of the bodies' other slices; its result is added to that of the ball test in the slot.
  struct SliceTest {
    BallTest test;
    std::size_t slot;
  };

  struct BoxTest {
    Picked balls;
    BoxLanes<Floats> boxes;
  };

  struct Sizes {
    Floats radius, room;
  };

  static std::size_t eights_of(std::size_t count) { return (count + kFloats - 1) / kFloats; }
  // Results are looked at by eights.
  std::size_t tests_room() const { return eights_of(pairs_.size()) * kFloats; }
  void add_ball_tests(std::vector<Partner> partners, const std::vector<std::vector<BoundingBall>>& slices,
                      const std::vector<std::size_t>& first_slice);
  void add_slice_tests(const std::vector<Partner>& partners, const std::vector<std::vector<BoundingBall>>& slices,
                       const std::vector<std::size_t>& first_slice);
  void add_box_tests(std::vector<Partner> partners, const std::vector<Box>& boxes);
  static std::uint8_t near_balls(const BallTest& test, const Posed* posed);
  static std::uint8_t near_boxes(const BoxTest& test, const Posed* posed);

  std::vector<BoundingBall> balls_;
  std::vector<Sizes> sizes_;  // of eight balls
  std::vector<BallTest> ball_tests_;
  std::vector<SliceTest> slice_tests_;
  std::vector<BoxTest> box_tests_;
  std::vector<std::array<std::int32_t, kFloats>> pairs_;  // by lane, of the tests of balls, then of those of boxes
};

inline std::uint8_t SingleStateFilter::near_balls(const BallTest& test, const Posed* posed) {
  const Posed &own = posed[test.balls.eight], &others = posed[test.others.eight];
  const auto of = [&](Floats Posed::* number) { return picked(own.*number, test.balls.places); };
  const auto of_other = [&](Floats Posed::* number) { return picked(others.*number, test.others.places); };
  const Floats x = of_other(&Posed::x) - of(&Posed::x), y = of_other(&Posed::y) - of(&Posed::y);
  const Floats z = of_other(&Posed::z) - of(&Posed::z);
  const Floats limit = far_beyond(of_other(&Posed::radius) + of(&Posed::radius));
  return static_cast<std::uint8_t>(~bits_above(dot_of(x, y, z, x, y, z), limit) & test.pairs);
}

inline std::uint8_t SingleStateFilter::near_boxes(const BoxTest& test, const Posed* posed) {
  const auto& [low, high, present] = test.boxes;
  const Posed& own = posed[test.balls.eight];
  const auto of = [&](Floats Posed::* number) { return picked(own.*number, test.balls.places); };
  const Floats x = beyond(of(&Posed::x), low[0], high[0]), y = beyond(of(&Posed::y), low[1], high[1]);
  const Floats z = beyond(of(&Posed::z), low[2], high[2]);
  const unsigned far = bits_above(dot_of(x, y, z, x, y, z), of(&Posed::limit));
  return static_cast<std::uint8_t>(~far & present);
}

// All tests first, without a branch: which partners are near is hard to predict.
template <class Found>
void SingleStateFilter::find(Workspace& w, Found found) const {
  const Posed* const posed = w.posed.data();  // bytes are written, which might be this pointer's own
  std::uint8_t* const near = w.near.data();
  std::uint8_t* next = near;
  for (const BallTest& test : ball_tests_) *next++ = near_balls(test, posed);
  for (const auto& [test, slot] : slice_tests_) {
    near[slot] = static_cast<std::uint8_t>(near[slot] | near_balls(test, posed));
  }
  for (const BoxTest& test : box_tests_) *next++ = near_boxes(test, posed);
  const std::size_t room = w.near.size();
  for (std::size_t first = 0; first < room; first += kFloats) {
    std::uint64_t eight;
    std::memcpy(&eight, near + first, sizeof eight);
    for (; eight != 0; eight &= eight - 1) {
      const auto bit = static_cast<std::size_t>(__builtin_ctzll(eight));
      found(pairs_[first + bit / kFloats][bit % kFloats]);
    }
  }
}

}  // namespace plannercheck
