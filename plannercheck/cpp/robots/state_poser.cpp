#include "robots/state_poser.hpp"

#include <algorithm>

#include "math/sincos.hpp"
#include "math/vec.hpp"
#include "robots/joints.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kTranslation = 3;  // the column

// A pose times a placement's translation.
Double4 placed_origin(const PoseColumns& on, const double* p) {
  const Double4* const c = on.column;
  return c[0] * p[3] + c[1] * p[7] + c[2] * p[11] + c[kTranslation];
}

// A pose times a placement whose rotation keeps one axis: that column stays, and the others are sums of two products.
template <std::size_t axis>
void place_turned(PoseColumns& pose, const double* p) {
  constexpr std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
  const Double4 origin = placed_origin(pose, p), a = pose.column[i], b = pose.column[j];
  pose.column[i] = a * p[4 * i + i] + b * p[4 * j + i];
  pose.column[j] = a * p[4 * i + j] + b * p[4 * j + j];
  pose.column[kTranslation] = origin;
}

void place_columns(PoseColumns& pose, const double* p, PlacementForm form) {
  switch (form) {
    case PlacementForm::kIdentity:
      return;
    case PlacementForm::kShift:
      pose.column[kTranslation] = placed_origin(pose, p);
      return;
    case PlacementForm::kTurnX:
      return place_turned<0>(pose, p);
    case PlacementForm::kTurnY:
      return place_turned<1>(pose, p);
    case PlacementForm::kTurnZ:
      return place_turned<2>(pose, p);
    case PlacementForm::kGeneral:
      const Double4 origin = placed_origin(pose, p);
      pose.rotate(p, 4);
      pose.column[kTranslation] = origin;
      return;
  }
}

// As lanes are filled with a constant: of zeros, only the positive one comes through.
template <class Number>
Number spread(Number value) {
  return Number{} + value;
}

double number_of(const JointValue& value, const double* q) {
  return value.column < 0 ? spread(value.offset) : value.multiplier * q[value.column] + value.offset;
}

}  // namespace

void StatePoser::begin(const Kinematics& kinematics, const unsigned char* needed) {
  PosingOrder order;
  order.find(kinematics, needed);
  steps_.clear(), angles_.clear(), turns_ = 0;
  const int links = kinematics.link_count();
  const auto place = [&](int joint) {
    if (joint < 0) return -1;
    const int home = order.home[static_cast<std::size_t>(joint)];
    return home < 0 ? links + joint : home;
  };
  places_.assign(kinematics.joints().size(), -1);
  for (const int i : order.joints) {
    const auto& joint = kinematics.joints()[static_cast<std::size_t>(i)];
    places_[at(i)] = place(i);
    add(place(joint.parent), place(i), joint.placement, joint.form, &joint);
  }
  for (const int i : order.links) {
    const auto& link = kinematics.links()[static_cast<std::size_t>(i)];
    add(place(link.joint), i, link.placement, link.form, nullptr);
  }
  poses_.resize(at(links) + kinematics.joints().size());
  cos_.resize(angles_.size()), sin_.resize(angles_.size());
}

void StatePoser::add(int parent, int to, const Rigid& placement, PlacementForm form, const Kinematics::Joint* joint) {
  Step step{parent, to, form, placement, joint, -1};
  if (parent < 0) std::transform(placement.m, placement.m + 12, step.placement.m, spread<double>);
  if (joint != nullptr && !joint->held && is_angle(joint->kind)) {
    step.turn = add_angle(joint->values[0]);
  }
  steps_.push_back(step);
}

// Returns its place. It has a column, or its joint would be held.
int StatePoser::add_angle(const JointValue& value) {
  const std::size_t lane = at(turns_) % kAngleLanes;
  if (lane == 0) angles_.emplace_back();
  Angles& angles = angles_.back();
  angles.column[lane] = value.column, angles.multiplier[lane] = value.multiplier, angles.offset[lane] = value.offset;
  return turns_++;
}

void StatePoser::take_turns(const double* q) {
  for (std::size_t k = 0; k < angles_.size(); ++k) {
    const Angles& angles = angles_[k];
    AngleLanes numbers;
    for (std::size_t lane = 0; lane < kAngleLanes; ++lane) numbers[lane] = q[angles.column[lane]];
    const auto found = sincos(angles.multiplier * numbers + angles.offset);
    cos_[k] = found.cos, sin_[k] = found.sin;
  }
}

inline void StatePoser::move_by(const Step& step, const double* q, PoseColumns& pose) const {
  const Kinematics::Joint& joint = *step.joint;
  double values[7];
  if (step.turn >= 0) {
    const std::size_t angles = at(step.turn) / kAngleLanes, lane = at(step.turn) % kAngleLanes;
    values[0] = cos_[angles][lane], values[1] = sin_[angles][lane];
  } else if (joint.held) {
    std::transform(joint.held_values, joint.held_values + 7, values, spread<double>);
  } else {
    for (int k = 0; k < value_count(joint.kind); ++k) values[k] = number_of(joint.values[k], q);
  }
  move(pose, joint.kind, joint.axis, values);
}

// A chain's pose stays in registers from joint to joint.
const PoseColumns* StatePoser::pose(const double* q) {
  take_turns(q);
  PoseColumns pose;
  int posed = -1;  // whose pose that is
  for (const Step& step : steps_) {
    if (step.parent < 0) {
      pose = columns_of(step.placement.m);
    } else {
      if (step.parent != posed) pose = poses_[at(step.parent)];
      place_columns(pose, step.placement.m, step.form);
    }
    if (step.joint != nullptr) move_by(step, q, pose);
    poses_[at(step.to)] = pose;
    posed = step.to;
  }
  return poses_.data();
}

}  // namespace plannercheck
