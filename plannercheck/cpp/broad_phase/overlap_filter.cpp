// Balls inside one body that meet a box inside another.
#include <cmath>
#include <optional>
#include <type_traits>

#include "broad_phase/body_bounds.hpp"
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

template <FloatVector Numbers>
InnerBallsInLanes<Numbers> posed_by(const FloatPoseOf<Numbers>& link, const InnerBallsInLanes<Numbers>& in_link,
                                    float room) {
  const auto& [x, y, z, radius] = in_link;
  InnerBallsInLanes<Numbers> p;
  p.x = link.turned(0, x, y, z) + link.m[3];
  p.y = link.turned(1, x, y, z) + link.m[7];
  p.z = link.turned(2, x, y, z) + link.m[11];
  const Numbers size = (absolute(p.x) + absolute(p.y)) + absolute(p.z);
  p.radius = radius - (size * static_cast<float>(kPosingError) + room);
  return p;
}

}  // namespace

void BodyBounds::find_inner_shapes(const std::vector<GeometryObject>& bodies) {
  balls_.resize(bodies.size()), inner_boxes_.resize(bodies.size());
  const auto can_meet = [&](std::int32_t balls, std::int32_t box) {
    return balls_[at(balls)].count > 0 && inner_boxes_[at(box)].exists;
  };
  for (const auto [a, b] : pairs_) {
    for (const std::int32_t body : {a, b}) {
      const GeometryObject& object = bodies[at(body)];
      if (object.link >= 0 && balls_[at(body)].link < 0) balls_[at(body)] = balls_of(object);
      if (!inner_boxes_[at(body)].exists) inner_boxes_[at(body)] = box_inside(*object.body);
    }
    roles_.push_back(can_meet(b, a) ? Roles{b, a} : can_meet(a, b) ? Roles{a, b} : Roles{});
  }
}

BodyBounds::Balls BodyBounds::balls_of(const GeometryObject& object) {
  const Polytope& body = *object.body;
  Balls out;
  out.link = object.link;
  for (const InnerBall& ball : body.inner_shapes().balls) {
    const Vec3 c = object.placement.apply(ball.centre);
    out.ball[out.count++] = {{static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)},
                             below((ball.radius + body.inflation_radius) * kShrunk)};
  }
  static_assert(kInnerBalls <= kFloats);
  out.side_by_side = InnerBallsInLanes<Floats>{Floats{}, Floats{}, Floats{}, Floats{} - __builtin_inff()};
  for (std::size_t k = 0; k < out.count; ++k) {
    const auto [x, y, z] = out.ball[k].centre;
    out.side_by_side.x[k] = x, out.side_by_side.y[k] = y, out.side_by_side.z[k] = z;
    out.side_by_side.radius[k] = out.ball[k].radius;
  }
  out.room =
      above((norm_1(object.placement.translation()) + 2 * (body.origin_radius + body.inflation_radius)) * kPosingError);
  return out;
}

BodyBounds::BoxInside BodyBounds::box_inside(const Polytope& body) {
  BoxInside out;
  // Obstacles are boxes more often than not, and need no balls.
  const std::optional<InnerBox> inner = body.is_box != 0 ? InnerBox{body.low, body.high, 0} : body.inner_shapes().box;
  if (!inner) return out;
  const Vec3 middle = 0.5 * (body.low + body.high);
  for (std::size_t j = 0; j < 3; ++j) {
    out.low[j] = static_cast<float>(inner->low[j] - middle[j]);
    out.high[j] = static_cast<float>(inner->high[j] - middle[j]);
  }
  out.exists = true;
  out.radius = below(inner->radius + body.inflation_radius);
  return out;
}

// No centre is further from its link's origin than the room, over kPosingError.
template <>
void BodyBounds::pose_balls(FloatBlock& poses, const Balls& balls, InnerBalls<FloatBlock>& out) {
  const FloatPose& link = poses.pose(at(balls.link));
  const PoseError error = poses.error(at(balls.link));
  const float room = balls.room + error.of_point(balls.room * static_cast<float>(1 / kPosingError));
  for (std::size_t k = 0; k < balls.count; ++k) {
    const auto& [centre, radius] = balls.ball[k];
    const auto in_all = [](float number) { return filled<StateFloats>(number); };
    out.ball[k] =
        posed_by<StateFloats>(link, {in_all(centre[0]), in_all(centre[1]), in_all(centre[2]), in_all(radius)}, room);
  }
}

template <>
void BodyBounds::pose_balls(SingleState& poses, const Balls& balls, InnerBalls<SingleState>& out) {
  out.all = posed_by(poses.pose(at(balls.link)), balls.side_by_side, balls.room);
}

template <FloatVector Numbers>
unsigned BodyBounds::meet(const InnerBallsInLanes<Numbers>& ball, const BoxInside& box,
                          const BoxInLanes<Numbers>& frame) {
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

template <class Poses>
Masks BodyBounds::by_inner_shapes(std::size_t pair, Posed<Poses>& posed) const {
  const Roles roles = roles_[pair];
  if (roles.balls < 0) return {};
  const Balls& own = balls_[at(roles.balls)];
  const InnerBalls<Poses>& balls =
      posed.balls_.of(at(roles.balls), false, [&](InnerBalls<Poses>& out) { pose_balls(*posed.poses_, own, out); });
  const auto& frame = box(at(roles.box), posed);
  const BoxInside& inner = inner_boxes_[at(roles.box)];
  if constexpr (std::is_same_v<Poses, SingleState>) {
    return {.overlap = meet(balls.all, inner, frame) != 0 ? 1U : 0U};
  } else {
    unsigned out = 0;
    for (std::size_t k = 0; k < own.count; ++k) out |= meet(balls.ball[k], inner, frame);
    return {.overlap = out};
  }
}
template Masks BodyBounds::by_inner_shapes(std::size_t, Posed<FloatBlock>&) const;
template Masks BodyBounds::by_inner_shapes(std::size_t, Posed<SingleState>&) const;

}  // namespace plannercheck
