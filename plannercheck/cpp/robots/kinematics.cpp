// Computes the poses of kinematics.hpp: placements, then motions of joints, elementwise on Lanes.
#include "robots/kinematics.hpp"

#include <algorithm>
#include <array>
#include <atomic>

#include "math/interruption.hpp"
#include "math/sincos.hpp"
#include "robots/joint_motions.hpp"
#include "robots/kinematics_lanes.hpp"
#include "robots/state_poser.hpp"

namespace plannercheck {
namespace {

constexpr int kPose = 12;  // numbers in a row-major 3x4 pose

inline void broadcast_pose(const Rigid& pose, Lanes* out) {
  for (int k = 0; k < kPose; ++k) out[k] = broadcast(pose.m[k]);
}

// parent * placement, both affine maps; `out` may not overlap `parent`.
template <class Number>
inline void place(const Number* parent, const double* p, Number* out) {
  for (int row = 0; row < 3; ++row) {
    const Number a = parent[4 * row], b = parent[4 * row + 1], c = parent[4 * row + 2];
    for (int col = 0; col < 3; ++col) out[4 * row + col] = a * p[col] + b * p[4 + col] + c * p[8 + col];
    out[4 * row + 3] = a * p[3] + b * p[7] + c * p[11] + parent[4 * row + 3];
  }
}

// The same where the placement's rotation is the identity.
inline void place_shift(const Lanes* parent, const double* p, Lanes* out) {
  for (int row = 0; row < 3; ++row) {
    const Lanes a = parent[4 * row], b = parent[4 * row + 1], c = parent[4 * row + 2];
    out[4 * row] = a;
    out[4 * row + 1] = b;
    out[4 * row + 2] = c;
    out[4 * row + 3] = a * p[3] + b * p[7] + c * p[11] + parent[4 * row + 3];
  }
}

// The same where the placement's rotation keeps one axis.
template <int axis>
inline void place_turn(const Lanes* parent, const double* p, Lanes* out) {
  constexpr int i = (axis + 1) % 3, j = (axis + 2) % 3;
  place_shift(parent, p, out);
  for (int row = 0; row < 3; ++row) {
    const Lanes a = parent[4 * row + i], b = parent[4 * row + j];
    out[4 * row + i] = a * p[4 * i + i] + b * p[4 * j + i];
    out[4 * row + j] = a * p[4 * i + j] + b * p[4 * j + j];
  }
}

inline void place(const Lanes* parent, const Rigid& placement, PlacementForm form, Lanes* out) {
  switch (form) {
    case PlacementForm::kIdentity:
      for (int k = 0; k < kPose; ++k) out[k] = parent[k];
      return;
    case PlacementForm::kShift:
      return place_shift(parent, placement.m, out);
    case PlacementForm::kTurnX:
      return place_turn<0>(parent, placement.m, out);
    case PlacementForm::kTurnY:
      return place_turn<1>(parent, placement.m, out);
    case PlacementForm::kTurnZ:
      return place_turn<2>(parent, placement.m, out);
    case PlacementForm::kGeneral:
      return place(parent, placement.m, out);
  }
}

// A placement on a posed joint, or in the world if the joint is null.
inline void pose_on(const Lanes* joint, const Rigid& placement, PlacementForm form, Lanes* out) {
  if (joint == nullptr) return broadcast_pose(placement, out);
  place(joint, placement, form, out);
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

// pose * rotation by the angle of (cos, sin) that takes column `from` towards column `to`.
inline void turn_columns(int from, int to, Lanes cos, Lanes sin, Lanes* pose) {
  for (int row = 0; row < 3; ++row) {
    const Lanes a = pose[4 * row + from], b = pose[4 * row + to];
    pose[4 * row + from] = cos * a + sin * b;
    pose[4 * row + to] = cos * b - sin * a;
  }
}

// pose * rotation, rotation 3x3 row-major.
inline void rotate(const std::array<Lanes, 9>& r, Lanes* pose) {
  for (std::size_t row = 0; row < 3; ++row) {
    const Lanes a = pose[4 * row], b = pose[4 * row + 1], c = pose[4 * row + 2];
    for (std::size_t col = 0; col < 3; ++col) pose[4 * row + col] = a * r[col] + b * r[3 + col] + c * r[6 + col];
  }
}

inline void slide(Lanes x, Lanes y, Lanes z, Lanes* pose) {
  for (int row = 0; row < 3; ++row) {
    pose[4 * row + 3] = pose[4 * row] * x + pose[4 * row + 1] * y + pose[4 * row + 2] * z + pose[4 * row + 3];
  }
}

// Moves a pose by a joint. v: the joint's values, cosine and sine in place of an angle; inlined, they stay in
// registers.
[[gnu::always_inline]] inline void move(JointKind kind, const double* axis, const Lanes* v, Lanes* pose) {
  switch (kind) {
    case JointKind::kTurnX:
    case JointKind::kUnitTurnX:
      return turn_columns(1, 2, v[0], v[1], pose);
    case JointKind::kTurnY:
    case JointKind::kUnitTurnY:
      return turn_columns(2, 0, v[0], v[1], pose);
    case JointKind::kTurnZ:
    case JointKind::kUnitTurnZ:
      return turn_columns(0, 1, v[0], v[1], pose);
    case JointKind::kTurnAxis:
    case JointKind::kUnitTurnAxis:
      return rotate(turn_about_axis(axis, v[0], v[1]), pose);
    case JointKind::kSlide:
      return slide(v[0] * axis[0], v[0] * axis[1], v[0] * axis[2], pose);
    case JointKind::kPlanar:
      slide(v[0], v[1], Lanes{}, pose);
      return turn_columns(0, 1, v[2], v[3], pose);
    case JointKind::kBall:
      return rotate(turn_of_quaternion(v), pose);
    case JointKind::kFree:
      slide(v[0], v[1], v[2], pose);
      return rotate(turn_of_quaternion(v + 3), pose);
  }
}

inline Lanes value_of(const JointValue& value, const Lanes* q) {
  return value.column < 0 ? broadcast(value.offset) : value.multiplier * q[value.column] + value.offset;
}

// Reads a joint's values in the form that `move` takes.
inline void read_values(JointKind kind, const JointValue* values, const Lanes* q, Lanes* v) {
  if (is_angle(kind)) {
    const SinCos turn = sincos(value_of(values[0], q));
    v[0] = turn.cos;
    v[1] = turn.sin;
    return;
  }
  for (int k = 0; k < value_count(kind); ++k) v[k] = value_of(values[k], q);
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
  Lanes pose[kPose], values[7];
  broadcast_pose(placement, pose);
  read_values(joint.kind, joint.values, nullptr, values);
  move(joint.kind, joint.axis, values, pose);
  Rigid out;
  for (int k = 0; k < kPose; ++k) out.m[k] = pose[k][0];
  return out;
}

void pose_joint(const Kinematics::Joint& joint, const Lanes* q, const Lanes* parent, Lanes* pose) {
  Lanes values[7];
  if (joint.held) {
    for (int k = 0; k < 7; ++k) values[k] = broadcast(joint.held_values[k]);
  } else {
    read_values(joint.kind, joint.values, q, values);
  }
  pose_on(parent, joint.placement, joint.form, pose);
  move(joint.kind, joint.axis, values, pose);
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
  for (int k = 0; k < kPose; ++k) out[k] = pose[k][lane];
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

void LinkPoser::begin(const Kinematics& kinematics, const unsigned char* needed) {
  kinematics_ = &kinematics;
  order_.find(kinematics, needed);
  homeless_.resize(kinematics.joints().size() * kPose);
}

Lanes* LinkPoser::at_joint(int joint, Lanes* out) {
  const int home = order_.home[static_cast<size_t>(joint)];
  return home < 0 ? homeless_.data() + joint * kPose : out + home * kPose;
}

void LinkPoser::pose(const Lanes* q, Lanes* out) {
  for (const int i : order_.joints) {
    const auto& joint = kinematics_->joints()[static_cast<size_t>(i)];
    pose_joint(joint, q, joint.parent < 0 ? nullptr : at_joint(joint.parent, out), at_joint(i, out));
  }
  for (const int i : order_.links) {
    const auto& link = kinematics_->links()[static_cast<size_t>(i)];
    pose_on(link.joint < 0 ? nullptr : at_joint(link.joint, out), link.placement, link.form, out + i * kPose);
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
  std::vector<Lanes> lanes(static_cast<size_t>(width_)), poses(links * kPose);
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
        if (needed[i]) scatter_pose(&poses[i * kPose], lane, row + i * 16);
      }
    }
  }
}

}  // namespace plannercheck
