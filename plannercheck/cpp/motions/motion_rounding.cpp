#include "motions/motion_rounding.hpp"

namespace plannercheck {
namespace {

// All rounding here (poses of bodies, directions, products, boxes) is some hundred u = 2^-53 of the operands.
constexpr double kRunRounding = 0x1p-42, kUnit = 0x1p-53;

// In addition, for each joint on a chain the error of the frame's computed turn, and for each part: the numbers of a
// quaternion between the ends err by up to 62u.
constexpr double kTurnRounding = 64 * kUnit, kPartRounding = 144 * kUnit;

}  // namespace

MotionRounding motion_rounding(const MotionModel& model, double extent, const Path& path, const MotionBound& bound,
                               double kinematic_error) {
  double size = 1 + extent + model.extent + bound.curvature / 8 + bound.arm;
  for (std::size_t c = 0; c < model.travel.size(); ++c) size += model.travel[c] * path.size(c);
  const double part = kRunRounding + kTurnRounding * model.joints + kPartRounding * model.depth + 4 * model.defect +
                      8 * model.depth * path.off_unit() + model.leverage * path.number_error();
  return {4 * kinematic_error + part * size, size};
}

}  // namespace plannercheck
