// Poses joints and links for kLanes configurations at once, step by step from parents to children.
#include "math/vec.hpp"
#include "robots/kinematics_lanes.hpp"
#include "robots/lane_pose.hpp"

namespace plannercheck {

void LinkPoser::begin(const Kinematics& kinematics, const unsigned char* needed) {
  PosingOrder order;
  order.find(kinematics, needed);
  steps_.clear(), read_.clear(), values_.clear();
  links_ = at(kinematics.link_count());
  const auto place_of = [&](int joint) {
    if (joint < 0) return -1;
    const int home = order.home[at(joint)];
    return home < 0 ? static_cast<int>(links_) + joint : home;
  };
  for (const int i : order.joints) {
    const Kinematics::Joint& joint = kinematics.joints()[at(i)];
    steps_.push_back({place_of(joint.parent), place_of(i), joint.form, &joint.placement, &joint, values_.size()});
    if (!joint.held) read_.push_back(steps_.size() - 1);
    for (const double value : joint.held_values) values_.push_back(broadcast(value));
  }
  for (const int i : order.links) {
    const Kinematics::Link& link = kinematics.links()[at(i)];
    steps_.push_back({place_of(link.joint), i, link.form, &link.placement, nullptr, 0});
  }
  homeless_.resize(kinematics.joints().size() * kPoseNumbers);
}

Lanes* LinkPoser::pose_at(int place, Lanes* out) {
  const std::size_t k = at(place);
  return k < links_ ? out + k * kPoseNumbers : &homeless_[(k - links_) * kPoseNumbers];
}

// All values are read first: in the loop over steps, sines would leave no registers for the pose.
void LinkPoser::pose(const Lanes* q, Lanes* out) {
  for (const std::size_t k : read_) {
    const Step& step = steps_[k];
    read_values(step.joint->kind, step.joint->values, q, &values_[step.values]);
  }
  LanePose pose;
  int posed = -1;  // whose pose that is
  for (const Step& step : steps_) {
    if (step.parent < 0) {
      pose = lane_pose(*step.placement);
    } else {
      if (step.parent != posed) pose = load_pose(pose_at(step.parent, out));
      place(pose.m, step.form, step.placement->m);
    }
    if (step.joint != nullptr) move(pose, step.joint->kind, step.joint->axis, &values_[step.values]);
    store_pose(pose_at(step.to, out), pose);
    posed = step.to;
  }
}

}  // namespace plannercheck
