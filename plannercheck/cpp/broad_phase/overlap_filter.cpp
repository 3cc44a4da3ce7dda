#include "broad_phase/overlap_filter.hpp"

#include <cmath>

#include "broad_phase/obstacle_tree.hpp"

namespace plannercheck {
namespace {

// Bounds in floats, u = 2^-24, for bodies posed by M, off rigid by δ <= 3.6e-6: lengths change by at most 0.51 δ. A
// ball's centre, posed from rounded numbers by three products and sums, errs by 6u of its own |.|_1 and 17u of that in
// the link: half of kPosingError. The middle of the box errs by at most its room (box_filter.cpp). Twice that room is
// taken; the other half, at least 2e-5 of the half edges' sum e, covers the following. Let r and ρ be the radii:
// - posing shrinks them to at least 1 − 0.51 δ of themselves;
// - let w be the centre less the middle. Its coordinates A w in the box' frame err by (15u + 1.01 δ) |w|, A being M's
//   transpose in floats in place of its inverse, and by 6u |w| more; |w| <= e + 2 (r + ρ) if the test says yes;
// - the distance from the box, its square, and rounding the box itself err by 10u (e + r + ρ);
// - posing stretches that distance, which is at most r + ρ, by 0.51 δ of itself.
// In all that is (1.01 δ + 31u) e + (3.04 δ + 52u)(r + ρ) < 5.5e-6 e + 1.41e-5 (r + ρ). The part of r is less than what
// kShrunk takes off r. As ρ <= e, the rest is below 1.97e-5 e, which is less than the room's other half.
// Where a pose errs by more than rounding (float_pose_error.hpp), a ball's centre errs as a point does, and so does the
// middle of the box, once more within its room. Directions of the box err by t = `turn`, so that w errs by t |w| more.
// The room's other half has 11.4 t e for the part of e and ρ, of which 3 t e is needed (box_filter.cpp); kShrunk has
// room for the part of r, 2 t r, as t <= 2^-14.
constexpr double kPosingError = 0x1p-18, kShrunk = 1 - 1.4e-4;
// Squares of shorter lengths lose bits to underflow.
constexpr float kShortest = 1e-16F;

float below(double value) { return std::nextafterf(static_cast<float>(value), -__builtin_inff()); }
float above(double value) { return std::nextafterf(static_cast<float>(value), __builtin_inff()); }

}  // namespace

BlockOverlaps::BlockOverlaps(const std::vector<GeometryObject>& bodies,
                             const std::vector<std::array<std::int32_t, 2>>& pairs)
    : balls_(bodies.size()), boxes_(bodies.size()) {
  const auto can_meet = [&](std::int32_t balls, std::int32_t box) {
    return balls_[at(balls)].count > 0 && boxes_[at(box)].exists;
  };
  for (const auto [a, b] : pairs) {
    for (const std::int32_t body : {a, b}) {
      const GeometryObject& object = bodies[at(body)];
      if (object.link >= 0 && balls_[at(body)].link < 0) balls_[at(body)] = balls_of(object);
      if (!boxes_[at(body)].exists) boxes_[at(body)] = box_of(*object.body);
    }
    roles_.push_back(can_meet(b, a) ? Roles{b, a} : can_meet(a, b) ? Roles{a, b} : Roles{});
  }
}

BlockOverlaps::Balls BlockOverlaps::balls_of(const GeometryObject& object) {
  const Polytope& body = *object.body;
  Balls out;
  out.link = object.link;
  for (const InnerBall& ball : body.inner_shapes().balls) {
    const Vec3 c = object.placement.apply(ball.centre);
    out.ball[out.count++] = {{static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)},
                             below((ball.radius + body.inflation_radius) * kShrunk)};
  }
  static_assert(kInnerBalls <= kFloats);
  out.side_by_side = SideBySide{Floats{}, Floats{}, Floats{}, Floats{} - __builtin_inff()};
  for (std::size_t k = 0; k < out.count; ++k) {
    const auto [x, y, z] = out.ball[k].centre;
    out.side_by_side.x[k] = x, out.side_by_side.y[k] = y, out.side_by_side.z[k] = z;
    out.side_by_side.radius[k] = out.ball[k].radius;
  }
  out.room =
      above((norm_1(object.placement.translation()) + 2 * (body.origin_radius + body.inflation_radius)) * kPosingError);
  return out;
}

BlockOverlaps::Box BlockOverlaps::box_of(const Polytope& body) {
  Box out;
  // Obstacles are boxes more often than not, and need no balls.
  const std::optional<InnerBox> inner = body.is_box != 0 ? InnerBox{body.low, body.high, 0} : body.inner_shapes().box;
  if (!inner) return out;
  const Vec3 middle = 0.5 * (body.low + body.high);
  for (std::size_t j = 0; j < 3; ++j) {
    const auto axis = static_cast<int>(j);
    out.low[j] = static_cast<float>(inner->low[axis] - middle[axis]);
    out.high[j] = static_cast<float>(inner->high[axis] - middle[axis]);
  }
  out.exists = true;
  out.radius = below(inner->radius + body.inflation_radius);
  return out;
}

// For the rounding of posing and the error of the pose. No centre is further from its link's origin than the room, over
// kPosingError.
float BlockOverlaps::room_of(const Balls& balls, const FloatLinkPoses& links) {
  return balls.room + links.error(at(balls.link)).of_point(balls.room * static_cast<float>(1 / kPosingError));
}

template <FloatVector Numbers>
BlockOverlaps::PosedBall<Numbers> BlockOverlaps::posed(const FloatPoseOf<Numbers>& link,
                                                       const PosedBall<Numbers>& in_link, float room) {
  const auto& [x, y, z, radius] = in_link;
  PosedBall<Numbers> p;
  p.x = link.turned(0, x, y, z) + link.m[3];
  p.y = link.turned(1, x, y, z) + link.m[7];
  p.z = link.turned(2, x, y, z) + link.m[11];
  const Numbers size = (absolute(p.x) + absolute(p.y)) + absolute(p.z);
  p.radius = radius - (size * static_cast<float>(kPosingError) + room);
  return p;
}

void BlockOverlaps::pose(FloatLinkPoses& links, const Balls& balls, PosedBalls& out) {
  const FloatPose& link = links.of(at(balls.link));
  const float room = room_of(balls, links);
  for (std::size_t k = 0; k < balls.count; ++k) {
    const auto& [centre, radius] = balls.ball[k];
    const auto in_all = [](float number) { return filled<StateFloats>(number); };
    out[k] = posed(link, {in_all(centre[0]), in_all(centre[1]), in_all(centre[2]), in_all(radius)}, room);
  }
}

template <FloatVector Numbers>
unsigned BlockOverlaps::meet(const PosedBall<Numbers>& ball, const Box& box,
                             const BlockBoxes::PosedIn<Numbers>& frame) {
  const Numbers x = ball.x - frame.centre[0], y = ball.y - frame.centre[1], z = ball.z - frame.centre[2];
  Numbers square = {};
#pragma GCC unroll 3
  for (std::size_t j = 0; j < 3; ++j) {
    const Numbers along = dot_of(frame.axes[3 * j], frame.axes[3 * j + 1], frame.axes[3 * j + 2], x, y, z);
    const Numbers outside = beyond(along, box.low[j], box.high[j]);
    square = multiply_add(outside, outside, square);
  }
  const Numbers limit = (ball.radius + box.radius) - 2 * frame.room;
  return bits_above(limit * limit, square) & bits_above(limit, Numbers{} + kShortest);
}

bool BlockOverlaps::overlap_in_state(FloatLinkPoses& links, std::size_t pair, const BlockBoxes& boxes,
                                     BlockBoxes::Workspace& posed_boxes, Workspace& w) const {
  const Roles roles = roles_[pair];
  if (roles.balls < 0) return false;
  const Balls& own = balls_[at(roles.balls)];
  const SideBySide& balls = w.in_state.of(at(roles.balls), false, [&](SideBySide& out) {
    out = posed(links.of_state(at(own.link)), own.side_by_side, own.room);
  });
  return meet(balls, boxes_[at(roles.box)], boxes.posed_in_state(links, at(roles.box), posed_boxes)) != 0;
}

unsigned BlockOverlaps::overlap(FloatLinkPoses& links, std::size_t pair, const BlockBoxes& boxes,
                                BlockBoxes::Workspace& posed_boxes, Workspace& w) const {
  const Roles roles = roles_[pair];
  if (roles.balls < 0) return 0;
  const Balls& own = balls_[at(roles.balls)];
  const PosedBalls& balls = w.in_block.of(at(roles.balls), false, [&](PosedBalls& out) { pose(links, own, out); });
  const BlockBoxes::Posed& frame = boxes.posed(links, at(roles.box), posed_boxes);
  const Box& box = boxes_[at(roles.box)];
  unsigned out = 0;
  for (std::size_t k = 0; k < own.count; ++k) out |= meet(balls[k], box, frame);
  return out;
}

}  // namespace plannercheck
