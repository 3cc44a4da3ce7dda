#include "block_boxes.hpp"

#include <algorithm>
#include <cmath>

#include "block.hpp"

namespace plannercheck {
namespace {

// Floats err by 2^-24. An axis' entries are rounded once, so the product of two axes, three terms, errs by at most
// 6 · 2^-24 of |u| |m| <= 1 + 1e-5, and a shadow's half length by that of the edges' sum, its sums included: kShadow.
// Centres are rounded once and subtracted, their product with an axis sums three terms: 6 · 2^-24 of both lengths,
// |.|_1 at least: kCentre. Both leave room for rounding what they are compared with.
constexpr double kShadow = 0x1p-20, kCentre = 0x1p-20;
// Poses are off rigid by 1e-6 at most, on a link by twice that: an edge's shadow on its own axis, and that of the two
// others, which should be nothing.
constexpr double kSkew = 2e-5;

float up(double value) { return std::nextafterf(static_cast<float>(value), __builtin_inff()); }

}  // namespace

BodyBox body_box(const MountedBody& mounted) {
  const Body& body = *mounted.body;
  const Pose& p = mounted.placement;
  BodyBox box;
  box.link = mounted.link;
  box.centre = p.apply(0.5 * (body.low + body.high));
  box.axes = {Vec3{p.m[0], p.m[4], p.m[8]}, Vec3{p.m[1], p.m[5], p.m[9]}, Vec3{p.m[2], p.m[6], p.m[10]}};
  box.upright = box.axes == std::array<Vec3, 3>{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  double edges = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    const auto axis = static_cast<int>(j);
    const double half = 0.5 * (body.high[axis] - body.low[axis]) + body.swell;
    box.half[j] = up(half);
    edges += half;
  }
  box.room = up((kSkew + kShadow) * edges + kCentre * (norm_1(box.centre) + body.reach) + 1e-35);
  return box;
}

BlockBoxes::Workspace BlockBoxes::new_workspace() const {
  Workspace w;
  w.posed.resize(boxes_.size());
  w.block_of.resize(boxes_.size());
  return w;
}

void BlockBoxes::spread(const BodyBox& box, Posed& posed) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    posed.centre[i].fill(static_cast<float>(box.centre[axis]));
    for (std::size_t j = 0; j < 3; ++j) posed.axes[3 * j + i].fill(static_cast<float>(box.axes[j][axis]));
  }
  posed.room.fill(box.room);
}

void BlockBoxes::pose(const Lanes* links, const BodyBox& box, Posed& posed) const {
  for (std::size_t group = 0; group < kBlockGroups; ++group) {
    const Lanes* m = links + pose_index(links_, group, at(box.link));
    const std::size_t lane = group * kLanes;
    Lanes size = {};
    for (std::size_t i = 0; i < 3; ++i) {
      const Lanes* row = m + 4 * i;
      const Lanes centre = ((row[0] * box.centre.x + row[1] * box.centre.y) + row[2] * box.centre.z) + row[3];
      size += absolute(centre);
      store_floats(&posed.centre[i][lane], centre);
      for (std::size_t j = 0; j < 3; ++j) {
        const Vec3 axis = box.axes[j];
        const Lanes entry = box.upright ? row[j] : (row[0] * axis.x + row[1] * axis.y) + row[2] * axis.z;
        store_floats(&posed.axes[3 * j + i][lane], entry);
      }
    }
    store_floats(&posed.room[lane], (size * kCentre + static_cast<double>(box.room)) * (1 + kCentre));
  }
}

const BlockBoxes::Posed& BlockBoxes::posed(const Lanes* links, std::size_t body, Workspace& w) const {
  const BodyBox& box = boxes_[body];
  const bool fixed = box.link < 0;
  if (w.block_of[body] == w.block || (fixed && w.block_of[body] != 0)) return w.posed[body];
  if (fixed) {
    spread(box, w.posed[body]);
  } else {
    pose(links, box, w.posed[body]);
  }
  w.block_of[body] = w.block;
  return w.posed[body];
}

unsigned BlockBoxes::apart(const Lanes* links, std::size_t a, std::size_t b, Workspace& w) const {
  const Posed &p = posed(links, a, w), &q = posed(links, b, w);
  const auto magnitude = [](Floats f) {
    return reinterpret_cast<Floats>(reinterpret_cast<FloatMask>(f) & (FloatMask{} + 0x7fffffff));
  };
  const auto load = [](const auto& from, std::size_t i) { return load_floats(from[i].data()); };
  const std::array<float, 3>&half_a = boxes_[a].half, &half_b = boxes_[b].half;
  const Floats room = load_floats(p.room.data()) + load_floats(q.room.data());
  const Floats x = load(p.centre, 0) - load(q.centre, 0), y = load(p.centre, 1) - load(q.centre, 1);
  const Floats z = load(p.centre, 2) - load(q.centre, 2);
  std::array<Floats, 3> shadow{};  // of a's edges on b's axes
  FloatMask out = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const Floats ax = load(p.axes, 3 * i), ay = load(p.axes, 3 * i + 1), az = load(p.axes, 3 * i + 2);
    Floats own = room + half_a[i];
    for (std::size_t j = 0; j < 3; ++j) {
      const Floats product =
          magnitude((ax * load(q.axes, 3 * j) + ay * load(q.axes, 3 * j + 1)) + az * load(q.axes, 3 * j + 2));
      own += product * half_b[j];
      shadow[j] += product * half_a[i];
    }
    out |= magnitude((ax * x + ay * y) + az * z) > own;
  }
  for (std::size_t j = 0; j < 3; ++j) {
    const Floats along = (load(q.axes, 3 * j) * x + load(q.axes, 3 * j + 1) * y) + load(q.axes, 3 * j + 2) * z;
    out |= magnitude(along) > (room + half_b[j]) + shadow[j];
  }
  return float_bits(out);
}

}  // namespace plannercheck
