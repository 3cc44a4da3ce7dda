// Boxes around bodies, and balls and boxes inside them: three filters, in lanes over states; for one state, balls are
// in lanes.
//
// In: posed links, the bodies' bounds in their own frames. Out: for a pair, the states in which a plane along a face of
// either box, or along two edges, separates both (box_filter.cpp), and the states in which a ball inside one body meets
// a box inside the other (overlap_filter.cpp): most of the states in which the bodies share a point. Both hold whatever
// the rounding.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/block_cache.hpp"
#include "broad_phase/filter.hpp"
#include "broad_phase/geometry_object.hpp"
#include "broad_phase/poses.hpp"
#include "broad_phase/state_block.hpp"
#include "math/simd.hpp"

namespace plannercheck {

// A box in its link's frame, or in the world: the rows of `axes` are unit vectors along its edges, up to rounding.
struct BodyBox {
  std::int32_t link;
  std::array<float, 3> centre;
  std::array<std::array<float, 3>, 3> axes;
  std::array<float, 3> half;  // half the edges, with the body's inflation radius
  bool upright;               // the axes are exactly those of the frame
  float room;                 // for axes that are off rigid, times the edges, and for the rounding of posing
};

template <FloatVector Numbers>
struct BoxInLanes {
  std::array<Numbers, 9> axes;  // of edge j: entries 3 j to 3 j + 2
  std::array<Numbers, 3> centre;
  Numbers room;
};

// A ball is surely inside the body if its radius is positive.
template <FloatVector Numbers>
struct InnerBallsInLanes {
  Numbers x, y, z, radius;
};

class BodyBounds {
 public:
  BodyBounds(const std::vector<GeometryObject>& bodies, std::vector<std::array<std::int32_t, 2>> pairs);

  // The balls inside a body: each with a state a lane, or in one state, a ball a lane.
  template <class Poses>
  struct InnerBalls;

  // By body, what is posed of it, when a filter first asks for it.
  template <class Poses>
  class Posed {
   public:
    explicit Posed(std::size_t bodies = 0) : boxes_(bodies), balls_(bodies) {}

    // The poses have to outlive all that is asked about them.
    void begin(Poses& poses) {
      poses_ = &poses;
      boxes_.begin(), balls_.begin();
    }

   private:
    friend class BodyBounds;

    Poses* poses_ = nullptr;
    BlockCache<BoxInLanes<typename Poses::Numbers>> boxes_;
    BlockCache<InnerBalls<Poses>> balls_;
  };
  template <class Poses>
  Posed<Poses> posed() const {
    return Posed<Poses>(boxes_.size());
  }

  Masks by_faces(std::size_t pair, Posed<FloatBlock>& posed) const;
  // Edges cost more than faces. Together, they are all planes that boxes need.
  Masks by_edges(std::size_t pair, Posed<FloatBlock>& posed) const;
  template <class Poses>
  Masks by_inner_shapes(std::size_t pair, Posed<Poses>& posed) const;

 private:
  struct Ball {
    std::array<float, 3> centre;
    float radius;
  };

  // The balls inside a body that moves, in its link's frame.
  struct Balls {
    std::int32_t link = -1;
    std::size_t count = 0;
    std::array<Ball, kInnerBalls> ball;
    // A ball a lane; lanes without one hold a radius that nothing meets.
    InnerBallsInLanes<Floats> side_by_side;
    float room = 0;  // for the rounding of posing, besides that of a posed centre
  };

  // The box inside any body, in the body's own frame, relative to the middle of the box around it; rounded by `radius`.
  struct BoxInside {
    bool exists = false;
    std::array<float, 3> low, high;
    float radius = 0;
  };

  // Which body of a pair gives the balls and which the box; −1 if neither can.
  struct Roles {
    std::int32_t balls = -1, box = -1;
  };

  std::vector<std::array<std::int32_t, 2>> pairs_;
  std::vector<BodyBox> boxes_;  // by body, as the next two
  std::vector<Balls> balls_;
  std::vector<BoxInside> inner_boxes_;
  std::vector<Roles> roles_;  // by pair

  void find_inner_shapes(const std::vector<GeometryObject>& bodies);
  static Balls balls_of(const GeometryObject& object);
  static BoxInside box_inside(const Polytope& body);

  // A body's box, posed at the first call.
  template <class Poses>
  const BoxInLanes<typename Poses::Numbers>& box(std::size_t body, Posed<Poses>& posed) const {
    const BodyBox& box = boxes_[body];
    return posed.boxes_.of(body, box.link < 0, [&](auto& out) { pose_box(*posed.poses_, box, out); });
  }
  template <class Poses>
  [[gnu::noinline]] static void pose_box(Poses& poses, const BodyBox& box, BoxInLanes<typename Poses::Numbers>& out);
  template <FloatVector Numbers>
  static unsigned meet(const InnerBallsInLanes<Numbers>& ball, const BoxInside& box, const BoxInLanes<Numbers>& frame);
  template <class Poses>
  [[gnu::noinline]] static void pose_balls(Poses& poses, const Balls& balls, InnerBalls<Poses>& out);
};

template <>
struct BodyBounds::InnerBalls<FloatBlock> {
  std::array<InnerBallsInLanes<StateFloats>, kInnerBalls> ball;
};
template <>
struct BodyBounds::InnerBalls<SingleState> {
  InnerBallsInLanes<Floats> all;
};

}  // namespace plannercheck
