#include "motions/motion_bounds.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

// Covers the rounding of rates and sums, some hundred operations, and of rotations off unit length by rounding. (Input
// that is further off counts in the certifier's slack.)
constexpr double kBoundRounding = 1 + 1e-9;

Rate rate_of(const JointDrive& joint, const Path& path) {
  if (joint.column < 0) return {};  // a held joint: no chain asks for it
  if (joint.kind == DriveKind::kPart) return path.bound(joint.column);
  const NumberBound of = path.bound(joint.column, joint.multiplier, joint.offset);
  return joint.kind == DriveKind::kTurn ? Rate{of.rate} : Rate{0, of.rate, of.size};
}

// No part has another rate later on.
RateChange change_of(const JointDrive& joint, const Path& path) {
  if (joint.column < 0 || joint.kind == DriveKind::kPart) return {};
  const double change = path.change(joint.column, joint.multiplier);
  return joint.kind == DriveKind::kTurn ? RateChange{change} : RateChange{0, change};
}

// No part has a tube.
Rate tube_rate_of(const JointDrive& joint, const Path& path) {
  if (joint.column < 0) return {};
  if (joint.kind == DriveKind::kPart) return {0, 0, path.bound(joint.column).extent};
  const double off = std::fabs(joint.multiplier) * path.tube(joint.column);
  if (joint.kind == DriveKind::kTurn) return {off};
  return {0, off, path.bound(joint.column, joint.multiplier, joint.offset).size + off};
}

// Whether the arms of a chain depend on the motion.
bool has_slides(const MotionChains& chains, std::size_t chain) {
  const auto begin = chains.entries.begin();
  return std::any_of(begin + chains.first_entry[chain], begin + chains.first_entry[chain + 1],
                     [](const ChainJoint& entry) { return entry.first_slide < entry.past_slides; });
}

constexpr auto kChainLanes = static_cast<std::size_t>(kLanes);

LaneMask chain_mask(const std::int64_t* from) {
  LaneMask mask;
  std::memcpy(&mask, from, sizeof mask);
  return mask;
}

double largest_lane(Lanes lanes) {
  double most = lanes[0];
  for (int k = 1; k < kLanes; ++k) most = larger(most, lanes[k]);
  return most;
}

// Numbers where the mask is set, else 0.
Lanes where(LaneMask mask, Lanes numbers) {
  return reinterpret_cast<Lanes>(mask & reinterpret_cast<LaneMask>(numbers));
}

}  // namespace

void rates_of(const MotionChains& chains, const Path& path, Rates& rates) {
  rates.joints.resize(chains.joints.size());
  for (std::size_t j = 0; j < chains.joints.size(); ++j) rates.joints[j] = rate_of(chains.joints[j], path);
  rates.changes.clear();
  if (!path.is_curve()) return;
  for (const JointDrive& joint : chains.joints) rates.changes.push_back(change_of(joint, path));
}

void tube_rates_of(const MotionChains& chains, const Path& path, Rates& rates) {
  rates.joints.resize(chains.joints.size());
  for (std::size_t j = 0; j < chains.joints.size(); ++j) rates.joints[j] = tube_rate_of(chains.joints[j], path);
}

MotionBound bound_of(const MotionChains& chains, std::size_t chain, const Rates& rates) {
  MotionBound bound;
  double turned = 0;  // Σ |ω_i| over the joints before this one
  const auto first = static_cast<std::size_t>(chains.first_entry[chain]);
  const auto past = static_cast<std::size_t>(chains.first_entry[chain + 1]);
  for (std::size_t e = first; e < past; ++e) {
    const ChainJoint& entry = chains.entries[e];
    const Rate& rate = rates.joints[at(entry.joint)];
    double arm = entry.arm;
    for (std::int32_t s = entry.first_slide; s < entry.past_slides; ++s) {
      arm += rates.joints[at(chains.slides[at(s)])].extent;
    }
    const double speed = rate.turn * arm + rate.slide;
    bound.arm = larger(bound.arm, arm);
    bound.speed += speed;
    bound.curvature += speed * (rate.turn + 2 * turned);
    if (rates.is_curve()) {
      const RateChange& change = rates.changes[at(entry.joint)];
      bound.curvature += change.turn * arm + change.slide;
    }
    turned += rate.turn;
  }
  bound.speed *= kBoundRounding;
  bound.curvature *= kBoundRounding;
  return bound;
}

MotionChains sorted_chains(const MotionChains& chains, std::vector<std::int32_t>& place) {
  const auto begin = [&](std::size_t chain) { return chains.entries.begin() + chains.first_entry[chain]; };
  std::vector<std::size_t> order(chains.first_entry.size() - 1);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (has_slides(chains, a) != has_slides(chains, b)) return has_slides(chains, b);
    return std::lexicographical_compare(begin(a), begin(a + 1), begin(b), begin(b + 1),
                                        [](const ChainJoint& x, const ChainJoint& y) { return x.joint < y.joint; });
  });
  MotionChains out{chains.joints, {}, chains.slides, {0}};
  place.resize(order.size());
  for (const std::size_t chain : order) {
    place[chain] = static_cast<std::int32_t>(out.first_entry.size()) - 1;
    out.entries.insert(out.entries.end(), begin(chain), begin(chain + 1));
    out.first_entry.push_back(static_cast<std::int32_t>(out.entries.size()));
  }
  return out;
}

ChainTable::ChainTable(const MotionChains& chains) : chains_(chains.first_entry.size() - 1) {
  for (const ChainJoint& entry : chains.entries) longest_entry_ = larger(longest_entry_, entry.arm);
  while (in_groups_ < chains_ && !has_slides(chains, in_groups_)) ++in_groups_;
  for (std::size_t k = 0; k < in_groups_; k += kChainLanes) add_group(chains, k, std::min(k + kChainLanes, in_groups_));
}

// Row by row takes the next joint of some chain, and of all chains that have it next: one that no chain has later on,
// if there is one, so that few rows are needed.
void ChainTable::add_group(const MotionChains& chains, std::size_t first, std::size_t past) {
  Group group{joints_.size(), 0};
  std::vector<std::pair<const ChainJoint*, const ChainJoint*>> left;
  for (std::size_t chain = first; chain < past; ++chain) {
    left.push_back(
        {chains.entries.data() + chains.first_entry[chain], chains.entries.data() + chains.first_entry[chain + 1]});
  }
  const auto is_later = [&](std::int32_t joint) {
    return std::any_of(left.begin(), left.end(), [&](const auto& rest) {
      return rest.first != rest.second &&
             std::any_of(rest.first + 1, rest.second, [&](const ChainJoint& e) { return e.joint == joint; });
    });
  };
  for (;;) {
    std::int32_t joint = -1;
    for (const auto& rest : left) {
      if (rest.first == rest.second) continue;
      if (joint < 0 || !is_later(rest.first->joint)) joint = rest.first->joint;
      if (!is_later(joint)) break;
    }
    if (joint < 0) break;
    joints_.push_back(at(joint));
    for (std::size_t lane = 0; lane < kChainLanes; ++lane) {
      const bool has = lane < left.size() && left[lane].first != left[lane].second && left[lane].first->joint == joint;
      arms_.push_back(has ? left[lane].first->arm : 0);
      on_chain_.push_back(has ? -1 : 0);
      longest_arm_ = larger(longest_arm_, arms_.back());
      if (has) ++left[lane].first;
    }
  }
  group.past_rows = joints_.size();
  groups_.push_back(group);
}

void ChainTable::bound(const MotionChains& chains, const Rates& rates, ChainBounds& out) const {
  return rates.is_curve() ? bound_rows<true>(chains, rates, out) : bound_rows<false>(chains, rates, out);
}

// The steps are those of `bound_of`; joints that are not on a chain add 0 to it.
template <bool is_curve>
void ChainTable::bound_rows(const MotionChains& chains, const Rates& rates, ChainBounds& out) const {
  out.curvature_.resize(1 + chains_ + kChainLanes), out.speed_.resize(1 + chains_ + kChainLanes);
  Lanes largest_curvature{}, largest_speed{};
  double *curvatures = &out.curvature_[1], *speeds = &out.speed_[1];
  for (const Group& group : groups_) {
    Lanes curvature{}, speed{}, turned{};
    for (std::size_t row = group.first_row; row < group.past_rows; ++row) {
      const Rate& rate = rates.joints[joints_[row]];
      const LaneMask on_chain = chain_mask(&on_chain_[row * kChainLanes]);
      const Lanes turn = where(on_chain, broadcast(rate.turn)), slide = where(on_chain, broadcast(rate.slide));
      const Lanes arms = load_lanes(&arms_[row * kChainLanes]), moved = turn * arms + slide;
      speed = speed + moved;
      curvature = curvature + moved * (turn + 2 * turned);
      if constexpr (is_curve) {
        const RateChange& change = rates.changes[joints_[row]];
        curvature = curvature + where(on_chain, broadcast(change.turn) * arms + broadcast(change.slide));
      }
      turned = turned + turn;
    }
    speed = speed * kBoundRounding, curvature = curvature * kBoundRounding;
    store_lanes(curvatures, curvature), store_lanes(speeds, speed);
    curvatures += kChainLanes, speeds += kChainLanes;
    largest_curvature = larger(largest_curvature, curvature), largest_speed = larger(largest_speed, speed);
  }
  out.largest_ = {largest_lane(largest_curvature), largest_lane(largest_speed), longest_arm_};
  for (std::size_t chain = in_groups_; chain < chains_; ++chain) {
    const MotionBound bound = bound_of(chains, chain, rates);
    out.curvature_[chain + 1] = bound.curvature, out.speed_[chain + 1] = bound.speed;
    out.largest_.curvature = larger(out.largest_.curvature, bound.curvature);
    out.largest_.speed = larger(out.largest_.speed, bound.speed);
    out.largest_.arm = larger(out.largest_.arm, bound.arm);
  }
}

void ChainTable::bound_tube(const MotionChains& chains, const Rates& rates, double room, ChainBounds& tube) const {
  bound(chains, rates, tube);
  tube.speed_[0] = 0;  // of what stands still
  for (double& shift : tube.speed_) shift += room / 2;
}

MotionBound ChainTable::at_most(const Rates& rates) const {
  Rate all;
  RateChange changed;
  for (const Rate& rate : rates.joints) all.turn += rate.turn, all.slide += rate.slide, all.extent += rate.extent;
  for (const RateChange& change : rates.changes) changed.turn += change.turn, changed.slide += change.slide;
  const double arm = longest_entry_ + all.extent, speed = (all.turn * arm + all.slide) * kBoundRounding;
  const double change = changed.turn * arm + changed.slide;
  return {(speed * 2 * all.turn + change) * kBoundRounding, speed, arm * kBoundRounding};
}

}  // namespace plannercheck
