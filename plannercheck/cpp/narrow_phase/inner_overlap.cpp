#include "narrow_phase/inner_overlap.hpp"

#include "bodies/inner_shapes.hpp"
#include "bodies/polytope.hpp"
#include "math/simd.hpp"

namespace plannercheck {
namespace {

// Bounds, u = 2^-53, for bodies posed by M, off rigid by d <= 3.6e-6, so that M changes lengths by 0.51 d at most. A
// ball of A of radius r around x is, in B's frame, around y = M_B^-1 w with w = M_A x + t_A - t_B. It holds all points
// there within r (1 - 1.02 d) of y, and what both inflation radii R add holds all within R (1 - 0.51 d) more. So both
// bodies share a point if y is within (r + R) * kShrunkInFrame of the box' or ball's radius around it. y is found as
// M_B^T w, which is off by d |y|, at most 3.61e-6 |w|; products, sums and rounding the distance add below 64u of |w|,
// of the radii and of B's reach. All of these are at most `reach`, of which kRoomInFrame is taken off.
constexpr double kShrunkInFrame = 1 - 4e-6, kRoomInFrame = 4e-6;

// Squares of shorter lengths lose bits to underflow.
constexpr double kShortestLimit = 1e-140;

// From one body's frame to the other's, but for their being off rigid.
struct BetweenFrames {
  std::array<Vec3, 3> rows;
  Vec3 shift;
};

BetweenFrames between(const Pose& from, const Pose& to) {
  const Vec3 x = from.column(0), y = from.column(1), z = from.column(2);
  BetweenFrames out;
  for (std::size_t j = 0; j < 3; ++j) {
    const Vec3 axis = to.column(j);
    out.rows[j] = {dot(axis, x), dot(axis, y), dot(axis, z)};
  }
  out.shift = to.rotate_back(from.translation() - to.translation());
  return out;
}

typedef std::array<Lanes, 3> LanePoints;

Lanes square_of(const LanePoints& way) { return (way[0] * way[0] + way[1] * way[1]) + way[2] * way[2]; }

// Whether limits are kept anywhere.
bool is_below(Lanes square, Lanes limit) { return bits((limit > kShortestLimit) & (square < limit * limit)) != 0; }

// A sharp box holds a smaller one that is rounded by as much: by twice the room, if it is large enough.
InnerBox rounded(const InnerBox& box, double room) {
  const Vec3 edges = box.high - box.low;
  const double by = smaller(2 * room, 0.5 * smaller(edges.x, smaller(edges.y, edges.z)));
  const Vec3 step{by, by, by};
  return {box.low + step, box.high - step, box.radius + by};
}

bool samples_meet(const InnerShapes& of_samples, const InnerShapes& inner, const BetweenFrames& way, double inflation,
                  double room) {
  if (!inner.box) return false;  // then there are no balls either, but of segments
  const InnerBox box = rounded(*inner.box, room);
  for (const SampleBlock& block : of_samples.samples) {
    for (std::size_t first = 0; first < kSamples; first += kLanes) {
      const auto entry = [&](std::size_t i) { return load_lanes(&block.entry[i][first]); };
      const Lanes x = entry(0), y = entry(1), z = entry(2);
      const Lanes radius = (entry(3) + inflation) * kShrunkInFrame - room;
      LanePoints at_sample, off_box;
      for (std::size_t j = 0; j < 3; ++j) {
        const Vec3 row = way.rows[j];
        at_sample[j] = ((x * row.x + y * row.y) + z * row.z) + way.shift[j];
        const Lanes in_box = smaller(larger(at_sample[j], broadcast(box.low[j])), broadcast(box.high[j]));
        off_box[j] = at_sample[j] - in_box;
      }
      if (is_below(square_of(off_box), radius + box.radius)) return true;
      for (const InnerBall& ball : inner.balls) {
        const LanePoints off{at_sample[0] - ball.centre.x, at_sample[1] - ball.centre.y, at_sample[2] - ball.centre.z};
        if (is_below(square_of(off), radius + ball.radius)) return true;
      }
    }
  }
  return false;
}

}  // namespace

bool inner_shapes_overlap(const PosedPolytope& a, const PosedPolytope& b) {
  const InnerShapes* const in_a = a.body->lazy_inner_shapes.known();
  const InnerShapes* const in_b = b.body->lazy_inner_shapes.known();
  if (in_a == nullptr || in_b == nullptr || !(in_a->box || in_b->box)) return false;
  const double inflation = a.body->inflation_radius + b.body->inflation_radius;
  const double reach =
      (a.body->origin_radius + b.body->origin_radius) + inflation + norm_1(a.pose.translation() - b.pose.translation());
  const double room = kRoomInFrame * reach;
  return samples_meet(*in_a, *in_b, between(a.pose, b.pose), inflation, room) ||
         samples_meet(*in_b, *in_a, between(b.pose, a.pose), inflation, room);
}

}  // namespace plannercheck
