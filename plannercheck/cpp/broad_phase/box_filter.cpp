// Planes along the faces and edges of boxes around two bodies: the test of PairFrame::boxes_apart, in floats and with
// more room for rounding.
#include <cmath>
#include <utility>

#include "bodies/box_edges.hpp"
#include "broad_phase/body_bounds.hpp"

namespace plannercheck {
namespace {

// Floats err by u = 2^-24. The entries of a pose and of an axis are rounded, as are three products of them and two
// sums: an entry of a posed axis errs by 5u. So the product of two axes errs by at most 22u of |u| |m| <= 1 + 1e-5, and
// half a projection by that much of the edges' sum: kShadow. A posed centre c errs in each entry by 6u of its numbers,
// at most 6u of its own and 29u of |c| in the link, in |.|_1. Differences of centres, times an axis, err by 13u of
// both: kCentre. Both constants leave room for rounding what they are compared with.
constexpr double kShadow = 0x1p-19, kCentre = 0x1p-19;
// Where a pose errs by more than rounding, its box' axes, as they are, are as good as any other directions to separate
// along. On an axis that errs by `turn`, its own half edges project to at most `turn` of their sum more, and so do the
// other box' if that is the one that errs; the centre errs as a point does.
// If two bodies have less room than this, both centres' |.|_1 are below 2^125, and nothing overflows.
constexpr float kLargestRoom = 0x1p106F;
// Bodies are off rigid by δ <= 3.6e-6 (plannercheck/robots/unit_lengths.py). Take the posed axis u of an edge, |u|² <=
// 1 + δ. On it, the body's own half edge h projects to h (1 + δ), the other half edges, whose axes v have |u v| <= δ,
// to δ h each, and the inflation radius grows by at most half δ of itself. The other body's inflation radius, as a part
// of its half edges, loses as much. In all: below 2 δ of the half edges' sums.
constexpr double kSkew = 2e-5;

// Edges. Let η bound how far the posed axes a_i of the first box are from an orthonormal frame: 0.51 δ, 8.7u of
// rounding and `turn`, and so for the second's axes b_j. The direction is L = a_i x b_j, no longer than 1 + 3 η.
// - On L, half edge k of the first body projects to |a_k L| of itself, and to 8.7u + `turn` more. a_k (a_i x b_j) is 0
//   for k = i, else ± a_m b_j for the third axis m but for 3.1 η. The same goes for the second body. With 7u for the
//   rounding of products and sums, that is below 1.2e-5 + 4.1 `turn` of the half edges' sums, δ for their inflation
//   radii included: what `room` has for faces is 2.1e-5 and 11.4 `turn`.
// - Both centres err as on faces' axes. For d, their difference, d L is (a_l d) (a_k b_j) − (a_k d) (a_l b_j), where k
//   and l follow i, but for 5.1 η |d| and 16u |d|_1: kTilt, as `turn` is at most 2^-14 (float_link_poser.cpp).
constexpr float kTilt = 3.3e-4F;

float up(double value) { return std::nextafterf(static_cast<float>(value), __builtin_inff()); }

BodyBox body_box(const GeometryObject& object) {
  const Polytope& body = *object.body;
  const Pose& p = object.placement;
  BodyBox box;
  box.link = object.link;
  const Vec3 centre = p.apply(0.5 * (body.low + body.high));
  box.upright = true;
  double edges = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    box.centre[j] = static_cast<float>(centre[j]);
    for (std::size_t i = 0; i < 3; ++i) {
      box.axes[j][i] = static_cast<float>(p.m[4 * i + j]);
      box.upright &= p.m[4 * i + j] == (i == j ? 1 : 0);
    }
    const double half = 0.5 * (body.high[j] - body.low[j]) + body.inflation_radius;
    box.half[j] = up(half);
    edges += half;
  }
  box.room = up((kSkew + kShadow) * edges + kCentre * (norm_1(centre) + body.origin_radius) + 1e-35);
  return box;
}

template <FloatVector Numbers>
void spread(const BodyBox& box, BoxInLanes<Numbers>& posed) {
  for (std::size_t j = 0; j < 3; ++j) {
    posed.centre[j] = Numbers{} + box.centre[j];
    for (std::size_t i = 0; i < 3; ++i) posed.axes[3 * j + i] = Numbers{} + box.axes[j][i];
  }
  posed.room = Numbers{} + box.room;
}

template <FloatVector Numbers>
void pose_on(const FloatPoseOf<Numbers>& link, PoseError error, const BodyBox& box, BoxInLanes<Numbers>& posed) {
  Numbers size = {};
  for (std::size_t i = 0; i < 3; ++i) {
    posed.centre[i] = link.turned(i, box.centre[0], box.centre[1], box.centre[2]) + link.m[4 * i + 3];
    size += absolute(posed.centre[i]);
    for (std::size_t j = 0; j < 3; ++j) {
      const std::array<float, 3>& axis = box.axes[j];
      posed.axes[3 * j + i] = box.upright ? link.m[4 * i + j] : link.turned(i, axis[0], axis[1], axis[2]);
    }
  }
  // The room, over kCentre, is at least 11.4 times the half edges' sum, and |c|.
  static_assert(kSkew + kShadow >= 11.4 * kCentre);
  const float room = box.room + error.of_point(box.room * static_cast<float>(1 / kCentre));
  posed.room = (size * static_cast<float>(kCentre) + room) * static_cast<float>(1 + kCentre);
}

}  // namespace

BodyBounds::BodyBounds(const std::vector<GeometryObject>& bodies, std::vector<std::array<std::int32_t, 2>> pairs)
    : pairs_(std::move(pairs)) {
  for (const GeometryObject& object : bodies) boxes_.push_back(body_box(object));
  find_inner_shapes(bodies);
}

template <class Poses>
void BodyBounds::pose_box(Poses& poses, const BodyBox& box, BoxInLanes<typename Poses::Numbers>& out) {
  if (box.link < 0) return spread(box, out);
  pose_on(poses.pose(at(box.link)), poses.error(at(box.link)), box, out);
}
template void BodyBounds::pose_box(FloatBlock&, const BodyBox&, BoxInLanes<StateFloats>&);
template void BodyBounds::pose_box(SingleState&, const BodyBox&, BoxInLanes<Floats>&);

Masks BodyBounds::by_faces(std::size_t pair, Posed<FloatBlock>& posed) const {
  const std::size_t a = at(pairs_[pair][0]), b = at(pairs_[pair][1]);
  const BoxInLanes<StateFloats>&p = box(a, posed), &q = box(b, posed);
  const std::array<float, 3>&half_a = boxes_[a].half, &half_b = boxes_[b].half;
  const StateFloats room = p.room + q.room;
  const StateFloats x = p.centre[0] - q.centre[0], y = p.centre[1] - q.centre[1], z = p.centre[2] - q.centre[2];
  std::array<StateFloats, 3> shadow;  // projections of b's half edges on its own axes and of a's on b's
  for (std::size_t j = 0; j < 3; ++j) shadow[j] = room + half_b[j];
  unsigned out = 0;
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i) {
    const StateFloats ax = p.axes[3 * i], ay = p.axes[3 * i + 1], az = p.axes[3 * i + 2];
    StateFloats own = room + half_a[i];
#pragma GCC unroll 3
    for (std::size_t j = 0; j < 3; ++j) {
      const StateFloats product = absolute(dot_of(ax, ay, az, q.axes[3 * j], q.axes[3 * j + 1], q.axes[3 * j + 2]));
      own = multiply_add(product, filled<StateFloats>(half_b[j]), own);
      shadow[j] = multiply_add(product, filled<StateFloats>(half_a[i]), shadow[j]);
    }
    out |= bits_above(absolute(dot_of(ax, ay, az, x, y, z)), own);
  }
#pragma GCC unroll 3
  for (std::size_t j = 0; j < 3; ++j) {
    const StateFloats along = dot_of(q.axes[3 * j], q.axes[3 * j + 1], q.axes[3 * j + 2], x, y, z);
    out |= bits_above(absolute(along), shadow[j]);
  }
  return {.apart = out & bits_above(StateFloats{} + kLargestRoom, room)};
}

Masks BodyBounds::by_edges(std::size_t pair, Posed<FloatBlock>& posed) const {
  const std::size_t a = at(pairs_[pair][0]), b = at(pairs_[pair][1]);
  const BoxInLanes<StateFloats>&p = box(a, posed), &q = box(b, posed);
  const std::array<float, 3>&half_a = boxes_[a].half, &half_b = boxes_[b].half;
  const StateFloats x = p.centre[0] - q.centre[0], y = p.centre[1] - q.centre[1], z = p.centre[2] - q.centre[2];
  const StateFloats room = p.room + q.room;
  const StateFloats tilted = room + ((absolute(x) + absolute(y)) + absolute(z)) * kTilt;
  std::array<StateFloats, 3> along, halves_a, halves_b;
  std::array<StateFloats, 9> product;
#pragma GCC unroll 3
  for (std::size_t i = 0; i < 3; ++i) {
    const StateFloats ax = p.axes[3 * i], ay = p.axes[3 * i + 1], az = p.axes[3 * i + 2];
    along[i] = dot_of(ax, ay, az, x, y, z);
    halves_a[i] = filled<StateFloats>(half_a[i]), halves_b[i] = filled<StateFloats>(half_b[i]);
#pragma GCC unroll 3
    for (std::size_t j = 0; j < 3; ++j) {
      product[3 * i + j] = dot_of(ax, ay, az, q.axes[3 * j], q.axes[3 * j + 1], q.axes[3 * j + 2]);
    }
  }
  BitsOfAny<StateFloats> out;
  any_edges(product, along, halves_a, halves_b, [&](StateFloats distance, StateFloats reach) {
    out.add_above(distance, reach + tilted);
    return false;
  });
  return {.apart = out.bits() & bits_above(StateFloats{} + kLargestRoom, room)};
}

}  // namespace plannercheck
