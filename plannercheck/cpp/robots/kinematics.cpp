// Makes the table of kinematics.hpp, and poses batches by it.
#include "robots/kinematics.hpp"

#include <algorithm>
#include <array>
#include <atomic>

#include "math/interruption.hpp"
#include "robots/joints.hpp"
#include "robots/kinematics_lanes.hpp"
#include "robots/lane_pose.hpp"
#include "robots/state_poser.hpp"

namespace plannercheck {
namespace {

// parent * placement, both affine maps; `out` may not overlap `parent`.
void place(const double* parent, const double* p, double* out) {
  for (int row = 0; row < 3; ++row) {
    const double a = parent[4 * row], b = parent[4 * row + 1], c = parent[4 * row + 2];
    for (int col = 0; col < 3; ++col) out[4 * row + col] = a * p[col] + b * p[4 + col] + c * p[8 + col];
    out[4 * row + 3] = a * p[3] + b * p[7] + c * p[11] + parent[4 * row + 3];
  }
}

// Whether the rotation maps the axis to itself, exactly.
bool keeps_axis(const Rigid& placement, int axis) {
  for (int k = 0; k < 3; ++k) {
    const double unit = k == axis ? 1.0 : 0.0;
    if (placement.m[4 * axis + k] != unit || placement.m[4 * k + axis] != unit) return false;
  }
  return true;
}

PlacementForm form_of(const Rigid& placement) {
  const double* m = placement.m;
  const bool at_origin = m[3] == 0.0 && m[7] == 0.0 && m[11] == 0.0;
  if (keeps_axis(placement, 0) && keeps_axis(placement, 1) && keeps_axis(placement, 2)) {
    return at_origin ? PlacementForm::kIdentity : PlacementForm::kShift;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (keeps_axis(placement, axis)) return static_cast<PlacementForm>(axis);
  }
  return PlacementForm::kGeneral;
}

bool is_held(const JointSpec& joint) {
  return std::all_of(joint.values, joint.values + value_count(joint.kind),
                     [](const JointValue& v) { return v.column < 0; });
}

Anchor anchor_of(int joint, const std::vector<Anchor>& anchors) {
  return joint < 0 ? Anchor{-1, false, {}} : anchors[static_cast<size_t>(joint)];
}

// A placement on a moving joint is returned as it is, one on something static in the world.
Rigid placed(const Anchor& anchor, const Rigid& placement) {
  if (!anchor.posed) return placement;
  Rigid out;
  place(anchor.pose.m, placement.m, out.m);
  return out;
}

// The pose of a joint that nothing moves, by the same operations as for moving ones.
Rigid moved_once(const JointSpec& joint, const Rigid& placement) {
  LanePose pose = lane_pose(placement);
  Lanes values[7];
  read_values(joint.kind, joint.values, nullptr, values);
  move(pose, joint.kind, joint.axis, values);
  Rigid out;
  for (std::size_t k = 0; k < kPoseNumbers; ++k) out.m[k] = pose.m[k][0];
  return out;
}

// kLanes rows of q, the last one repeated if there are fewer, as Lanes.
void gather(const double* q, int rows, int width, Lanes* out) {
  for (int col = 0; col < width; ++col) {
    for (int lane = 0; lane < kLanes; ++lane) out[col][lane] = q[std::min(lane, rows - 1) * width + col];
  }
}

void end_matrix(double* out) {
  out[12] = out[13] = out[14] = 0.0;
  out[15] = 1.0;
}

void scatter_pose(const Lanes* pose, int lane, double* out) {
  for (std::size_t k = 0; k < kPoseNumbers; ++k) out[k] = pose[k][lane];
  end_matrix(out);
}

// Numbers every Kinematics, so that workspaces know it again.
std::atomic<std::uint64_t> kinematics_made{0};

}  // namespace

Kinematics::Kinematics(int width, const std::vector<JointSpec>& joints, const std::vector<LinkSpec>& links)
    : id_(++kinematics_made), width_(width) {
  std::vector<Anchor> anchors(joints.size());
  for (size_t i = 0; i < joints.size(); ++i) anchors[i] = add_joint(joints[i], anchors);
  for (const LinkSpec& link : links) {
    const Anchor anchor = anchor_of(link.joint, anchors);
    const Rigid placement = placed(anchor, link.placement);
    links_.push_back({anchor.joint, placement, form_of(placement)});
  }
}

Anchor Kinematics::add_joint(const JointSpec& spec, const std::vector<Anchor>& anchors) {
  const Anchor parent = anchor_of(spec.parent, anchors);
  const Rigid placement = placed(parent, spec.placement);
  const bool held = is_held(spec);
  if (held && parent.joint < 0) return {-1, true, moved_once(spec, placement)};
  Joint joint{parent.joint, spec.kind, held, {}, placement, form_of(placement), {}, {}};
  std::copy_n(spec.axis, 3, joint.axis);
  std::copy_n(spec.values, 7, joint.values);
  if (held) {
    Lanes values[7]{};
    read_values(spec.kind, spec.values, nullptr, values);
    for (int k = 0; k < 7; ++k) joint.held_values[k] = values[k][0];
  }
  joints_.push_back(joint);
  return {static_cast<int>(joints_.size()) - 1, false, {}};
}

void PosingOrder::find(const Kinematics& kinematics, const unsigned char* needed) {
  const auto& of_joints = kinematics.joints();
  const auto& of_links = kinematics.links();
  constexpr int kNotNeeded = -2, kHomeless = -1;
  home.assign(of_joints.size(), kNotNeeded);
  links.clear(), joints.clear();
  for (size_t i = 0; i < of_links.size(); ++i) {
    if (!needed[i]) continue;
    int* const own = of_links[i].joint < 0 ? nullptr : &home[static_cast<size_t>(of_links[i].joint)];
    if (own != nullptr) *own = std::max(*own, kHomeless);
    if (own != nullptr && of_links[i].form == PlacementForm::kIdentity && *own == kHomeless) {
      *own = static_cast<int>(i);
    } else {
      links.push_back(static_cast<int>(i));
    }
  }
  for (size_t i = of_joints.size(); i-- > 0;) {
    if (home[i] == kNotNeeded || of_joints[i].parent < 0) continue;
    int& parent = home[static_cast<size_t>(of_joints[i].parent)];
    parent = std::max(parent, kHomeless);
  }
  for (size_t i = 0; i < of_joints.size(); ++i) {
    if (home[i] != kNotNeeded) joints.push_back(static_cast<int>(i));
  }
}

void Kinematics::link_poses_of_state(const double* q, const unsigned char* needed, double* out) const {
  StatePoser poser;
  poser.begin(*this, needed);
  const PoseColumns* const poses = poser.pose(q);
  for (size_t i = 0; i < links_.size(); ++i) {
    if (!needed[i]) continue;
    const Pose pose = poses[i].by_rows();
    std::copy(pose.m.begin(), pose.m.end(), out + i * 16);
    end_matrix(out + i * 16);
  }
}

void Kinematics::link_poses_batch(const double* q, long long n, const unsigned char* needed, double* out) const {
  const size_t links = links_.size();
  if (n == 1) return link_poses_of_state(q, needed, out);
  std::vector<Lanes> lanes(static_cast<size_t>(width_)), poses(links * kPoseNumbers);
  LinkPoser poser;
  poser.begin(*this, needed);
  for (long long first = 0; first < n; first += kLanes) {
    poll_interruption();
    const int rows = static_cast<int>(std::min<long long>(kLanes, n - first));
    gather(q + first * width_, rows, width_, lanes.data());
    poser.pose(lanes.data(), poses.data());
    for (int lane = 0; lane < rows; ++lane) {
      double* row = out + (static_cast<size_t>(first) + static_cast<size_t>(lane)) * links * 16;
      for (size_t i = 0; i < links; ++i) {
        if (needed[i]) scatter_pose(&poses[i * kPoseNumbers], lane, row + i * 16);
      }
    }
  }
}

}  // namespace plannercheck
