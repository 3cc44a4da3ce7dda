#include "planar/motion_bounds_2d.hpp"

#include <algorithm>
#include <cmath>

#include "math/vec.hpp"

namespace plannercheck {
namespace {

// The largest |u| of the points within `radius` of x, y.
double arm_length(double x, double y, double radius) { return (norm_above({x, y, 0}) + radius) * (1 + 0x1p-40); }

}  // namespace

PlanarChain planar_chain(const std::vector<PlanarLink>& links, std::int32_t frame, const PlanarGeometryObject& body) {
  PlanarChain chain;
  double x = body.x, y = body.y, radius = body.radius;
  for (std::int32_t k = body.link; k != frame; k = links[at(k)].parent) {
    const PlanarLink& link = links[at(k)];
    const double c = std::cos(link.angle), s = std::sin(link.angle);
    const double turned_x = c * x - s * y, turned_y = s * x + c * y;
    if (link.joint == PlanarJoint::kFixed) {
      x = link.x + turned_x, y = link.y + turned_y;
      continue;
    }
    const bool is_root = link.joint == PlanarJoint::kFree;
    chain.arms.push_back(
        {link.column + (is_root ? 2 : 0), is_root, turned_x, turned_y, radius, arm_length(turned_x, turned_y, radius)});
    x = link.x, y = link.y, radius = 0;
  }
  std::reverse(chain.arms.begin(), chain.arms.end());
  return chain;
}

std::int32_t common_link(const std::vector<PlanarLink>& links, std::int32_t a, std::int32_t b) {
  while (a != b) (a > b ? a : b) = links[at(a > b ? a : b)].parent;  // parents come first
  return a;
}

PlanarBound planar_bound(const PlanarChain& chain, const PlanarPiece& piece, const std::vector<double>& rates) {
  PlanarBound bound;
  double rate = 0;
  for (const PlanarArm& arm : chain.arms) {
    rate += rates[at(arm.column)];
    const bool is_shifted = arm.is_root && (piece.arm_x != 0 || piece.arm_y != 0);
    const double length = is_shifted ? arm_length(arm.x + piece.arm_x, arm.y + piece.arm_y, arm.radius) : arm.length;
    bound.speed += std::fabs(rate) * length;
    bound.curvature += rate * rate * length;
  }
  return bound;
}

}  // namespace plannercheck
