#include "motions/motion_bounds.hpp"

#include <algorithm>
#include <numeric>

#include "math/simd.hpp"

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

constexpr auto kChainLanes = static_cast<std::size_t>(kLanes);

}  // namespace

void rates_of(const MotionChains& chains, const ConfigurationPath& path, std::vector<Rate>& rates) {
  rates.resize(chains.joints.size() + 1);
  for (std::size_t j = 0; j < chains.joints.size(); ++j) rates[j] = rate_of(chains.joints[j], path);
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

ChainTable::ChainTable(const MotionChains& chains) : joint_count_(chains.joints.size()) {
  std::vector<std::size_t> order;
  const auto first = [&](std::size_t chain) { return at(chains.first_entry[chain]); };
  const auto length = [&](std::size_t chain) { return first(chain + 1) - first(chain); };
  for (std::size_t chain = 0; chain + 1 < chains.first_entry.size(); ++chain) {
    const auto begin = chains.entries.begin() + static_cast<std::ptrdiff_t>(first(chain));
    const bool slides = std::any_of(begin, begin + static_cast<std::ptrdiff_t>(length(chain)),
                                    [](const ChainJoint& entry) { return entry.first_slide < entry.past_slides; });
    (slides ? with_slides_ : order).push_back(chain);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return length(a) < length(b); });
  for (std::size_t k = 0; k < order.size(); k += kChainLanes) {
    Group group{joints_.size(), 0, {}, {}};
    group.chains.assign(order.begin() + static_cast<std::ptrdiff_t>(k),
                        order.begin() + static_cast<std::ptrdiff_t>(std::min(k + kChainLanes, order.size())));
    group.entries = length(group.chains.back());
    for (std::size_t e = 0; e < group.entries; ++e) {
      for (std::size_t lane = 0; lane < kChainLanes; ++lane) {
        const std::size_t chain = group.chains[std::min(lane, group.chains.size() - 1)];
        const bool has = e < length(chain);
        const ChainJoint entry = has ? chains.entries[first(chain) + e] : ChainJoint{};
        joints_.push_back(has ? at(entry.joint) : joint_count_);
        arms_.push_back(has ? entry.arm : 0);
        longest_arm_ = larger(longest_arm_, arms_.back());
      }
      const auto row = joints_.end() - static_cast<std::ptrdiff_t>(kChainLanes);
      group.alike.push_back(std::all_of(row, joints_.end(), [&](std::size_t joint) { return joint == *row; }));
    }
    groups_.push_back(std::move(group));
  }
}

// The steps are those of `bound_of`; joints that stand still add 0.
void ChainTable::bound(const MotionChains& chains, const std::vector<Rate>& rates, ChainBounds& out) const {
  out.largest_curvature_ = 0, out.longest_arm_ = longest_arm_;
  const auto take = [&](std::size_t chain, double curvature, double speed) {
    out.curvature_[chain + 1] = curvature, out.speed_[chain + 1] = speed;
    out.largest_curvature_ = larger(out.largest_curvature_, curvature);
  };
  for (const Group& group : groups_) {
    Lanes curvature{}, speed{}, turned{};
    for (std::size_t e = 0; e < group.entries; ++e) {
      const std::size_t row = group.first_entry + e * kChainLanes;
      Lanes turn = broadcast(rates[joints_[row]].turn), slide = broadcast(rates[joints_[row]].slide);
      for (std::size_t lane = 1; lane < kChainLanes && group.alike[e] == 0; ++lane) {
        const Rate& rate = rates[joints_[row + lane]];
        turn[lane] = rate.turn, slide[lane] = rate.slide;
      }
      const Lanes moved = turn * load_lanes(&arms_[row]) + slide;
      speed = speed + moved;
      curvature = curvature + moved * (turn + 2 * turned);
      turned = turned + turn;
    }
    speed = speed * kBoundRounding, curvature = curvature * kBoundRounding;
    for (std::size_t lane = 0; lane < group.chains.size(); ++lane) {
      take(group.chains[lane], curvature[lane], speed[lane]);
    }
  }
  for (const std::size_t chain : with_slides_) {
    const MotionBound bound = bound_of(chains, chain, rates);
    take(chain, bound.curvature, bound.speed);
    out.longest_arm_ = larger(out.longest_arm_, bound.arm);
  }
}

}  // namespace plannercheck
