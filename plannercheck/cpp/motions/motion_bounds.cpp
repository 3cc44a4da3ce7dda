#include "motions/motion_bounds.hpp"

namespace plannercheck {
namespace {

// Covers the rounding of rates and sums, some hundred operations, and of rotations off unit length by rounding. (Input
// that is further off counts in the certifier's slack.)
constexpr double kBoundRounding = 1 + 1e-9;

Rate rate_of(const JointDrive& joint, const ConfigurationPath& path) {
  if (joint.column < 0) return {};  // a held joint: no chain asks for it
  if (joint.kind == DriveKind::kPart) return path.rate(joint.column);
  const double a = joint.multiplier * path.start(joint.column), b = joint.multiplier * path.end(joint.column);
  const double way = std::fabs(b - a);
  if (joint.kind == DriveKind::kTurn) return {way, 0, 0};
  return {0, way, larger(std::fabs(a + joint.offset), std::fabs(b + joint.offset))};
}

}  // namespace

void rates_of(const MotionChains& chains, const ConfigurationPath& path, std::vector<Rate>& rates) {
  rates.resize(chains.joints.size());
  for (std::size_t j = 0; j < rates.size(); ++j) rates[j] = rate_of(chains.joints[j], path);
}

MotionBound bound_of(const MotionChains& chains, std::size_t chain, const std::vector<Rate>& rates) {
  MotionBound bound;
  double turned = 0;  // Σ |ω_i| over the joints before this one
  const auto first = static_cast<std::size_t>(chains.first_entry[chain]);
  const auto past = static_cast<std::size_t>(chains.first_entry[chain + 1]);
  for (std::size_t e = first; e < past; ++e) {
    const ChainJoint& entry = chains.entries[e];
    const Rate& rate = rates[static_cast<std::size_t>(entry.joint)];
    double arm = entry.arm;
    for (std::int32_t s = entry.first_slide; s < entry.past_slides; ++s) {
      arm += rates[static_cast<std::size_t>(chains.slides[static_cast<std::size_t>(s)])].extent;
    }
    const double speed = rate.turn * arm + rate.slide;
    bound.arm = larger(bound.arm, arm);
    bound.speed += speed;
    bound.curvature += speed * (rate.turn + 2 * turned);
    turned += rate.turn;
  }
  bound.speed *= kBoundRounding;
  bound.curvature *= kBoundRounding;
  return bound;
}

}  // namespace plannercheck
