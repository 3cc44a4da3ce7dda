#include "planar/motion_certifier_2d.hpp"

#include <cmath>

#include "math/vec.hpp"

namespace plannercheck {
namespace {

// All rounding (of configurations, poses, lengths of directions, products, boxes) is some hundred u = 2^-53 of the
// coordinates involved and, for each link of the chain, as much of the angles times the reach. Taking whole turns off
// an angle rounds it by 3u of the angle before.
constexpr double kPlanarRounding = 0x1p-43;

double with_room(double length) { return length * (1 + 0x1p-40); }

PlanarHull hull_of(const PlanarGeometryObject& body) {
  PlanarHull hull;
  const auto& m = body.pose.m;
  for (std::size_t k = 0; k < body.shape.count; ++k) {
    const double x = body.shape.x(k), y = body.shape.y(k);
    hull.x.push_back(body.link < 0 ? m[0] * x + m[1] * y + m[2] : x);
    hull.y.push_back(body.link < 0 ? m[3] * x + m[4] * y + m[5] : y);
  }
  return hull;
}

}  // namespace

PlanarCertifier::PlanarCertifier(std::vector<PlanarLink> links, std::int32_t width,
                                 std::vector<PlanarGeometryObject> bodies,
                                 const std::vector<std::array<std::int32_t, 2>>& pairs)
    : links_(std::move(links)), width_(at(width)), bodies_(std::move(bodies)) {
  std::vector<bool> used(bodies_.size(), false);
  for (const auto& [a, b] : pairs) {
    const PlanarGeometryObject &first = bodies_[at(a)], &second = bodies_[at(b)];
    used[at(a)] = used[at(b)] = true;
    if (second.link < 0) {
      pairs_.push_back({a, b, -1, planar_chain(links_, -1, first), {}});
      continue;
    }
    const std::int32_t frame = common_link(links_, first.link, second.link);
    pairs_.push_back({a, b, frame, planar_chain(links_, frame, first), planar_chain(links_, frame, second)});
  }
  for (const PlanarLink& link : links_) {
    reach_ += with_room(std::hypot(link.x, link.y));
    anchor_turns_ += std::fabs(link.angle);
  }
  double furthest = 0;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const PlanarGeometryObject& body = bodies_[k];
    hulls_.push_back(hull_of(body));
    if (body.link < 0) {
      for (const double side : body.box) still_size_ = larger(still_size_, 4 * std::fabs(side));
      for (std::size_t i = 0; i < body.shape.count; ++i)  // the terms of a posed vertex, which may cancel
        still_size_ = larger(still_size_, 4 * (std::fabs(body.shape.x(i)) + std::fabs(body.shape.y(i)) +
                                               std::fabs(body.pose.m[2]) + std::fabs(body.pose.m[5])));
    } else {
      furthest = larger(furthest, std::fabs(body.x) + std::fabs(body.y) + body.radius);
      if (used[k]) movers_.push_back(static_cast<std::int32_t>(k));
    }
  }
  reach_ += furthest;
}

std::vector<std::int32_t> PlanarCertifier::frames() const {
  std::vector<std::int32_t> out;
  for (const PlanarMotionPair& pair : pairs_) out.push_back(pair.frame);
  return out;
}

PlanarPiece PlanarCertifier::straight(const double* q0, const double* q1) const {
  if (links_[0].joint != PlanarJoint::kFree) return {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  return {0, 1, q0[0], q0[1], q1[0] - q0[0], q1[1] - q0[1], q0[2], q1[2] - q0[2], 0, 0, 0};
}

double PlanarCertifier::rounding(const PlanarMotion& motion) const {
  double place = 0, turns = 1 + anchor_turns_;
  for (std::size_t k = 0; k < motion.count; ++k) {
    const PlanarPiece& p = motion.pieces[k];
    place = larger(place, std::fabs(p.origin_x) + std::fabs(p.origin_y) + std::fabs(p.way_x) + std::fabs(p.way_y) +
                              std::fabs(p.arm_x) + std::fabs(p.arm_y));
    turns = larger(turns, 1 + anchor_turns_ + std::fabs(p.heading) + std::fabs(p.turn));
  }
  // A root's heading, too: pieces of a curve begin at it less its whole turns.
  const std::size_t first = links_[0].joint == PlanarJoint::kFree ? 2 : 0;
  for (std::size_t c = first; c < width_; ++c)
    turns += std::fabs(motion.q0[c]) + larger(std::fabs(motion.q1[c]), std::fabs(motion.given[c]));
  const double size = 1 + reach_ + place + still_size_;
  return kPlanarRounding * static_cast<double>(links_.size() + 1) * size * turns;
}

}  // namespace plannercheck
