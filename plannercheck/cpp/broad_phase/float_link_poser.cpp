#include "broad_phase/float_link_poser.hpp"

#include <algorithm>
#include <cmath>

#include "math/vec.hpp"
#include "robots/joints.hpp"
#include "robots/pose_rows.hpp"
#include "robots/posing_order.hpp"

namespace plannercheck {
namespace {

// Parents of steps besides places among the poses: the world, and the pose that the step before left.
constexpr int kWorld = -1, kInHand = -2;

// Sums of numbers above this might overflow.
constexpr double kLargestDistance = 1e30;

// The filters' bounds hold for directions that are off by no more than this (overlap_filter.cpp).
constexpr float kMostTurn = 0x1p-14F;

// Axes are off unit length by rounding alone.
constexpr double kMostOffUnit = 1e-12;

StateFloats in_all(float value) { return filled<StateFloats>(value); }

void slide(FloatPose& pose, const std::array<float, 3>& axis, StateFloats distance) {
#pragma GCC unroll 3
  for (std::size_t k = 0; k < 3; ++k) {
    StateFloats* const row = &pose.m[4 * k];
    row[3] = (row[0] * axis[0] + row[1] * axis[1] + row[2] * axis[2]) * distance + row[3];
  }
}

// ----- turns about any axis

// A rotation that takes z to a unit axis, without translation.
Rigid frame_about(const double* axis) {
  const Vec3 z{axis[0], axis[1], axis[2]};
  const Vec3 x = unit(std::fabs(z.x) < 0.6 ? cross({1, 0, 0}, z) : cross({0, 1, 0}, z)), y = cross(z, x);
  return {{x.x, y.x, z.x, 0, x.y, y.y, z.y, 0, x.z, y.z, z.z, 0}};
}

Rigid inverse_rotation(const Rigid& r) {
  const double* const m = r.m;
  return {{m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0}};
}

// A placement times a rotation.
Rigid turned(const Rigid& placement, const Rigid& rotation) {
  Rigid out = placement;
  const double *const p = placement.m, *const r = rotation.m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      out.m[4 * i + j] = p[4 * i] * r[j] + p[4 * i + 1] * r[4 + j] + p[4 * i + 2] * r[8 + j];
    }
  }
  return out;
}

bool has_unit_axis(const Kinematics::Joint& joint) {
  return std::fabs(norm({joint.axis[0], joint.axis[1], joint.axis[2]}) - 1) <= kMostOffUnit;
}

bool can_be_posed(const Kinematics::Joint& joint) {
  if (joint.kind == JointKind::kTurnAxis) return has_unit_axis(joint);
  return is_angle(joint.kind) || joint.kind == JointKind::kSlide;
}

}  // namespace

void FloatLinkPoser::begin(const Kinematics& kinematics, const unsigned char* needed) {
  PosingOrder order;
  order.find(kinematics, needed);
  const std::size_t links = at(kinematics.link_count());
  steps_.clear(), read_.clear(), turns_.clear(), slides_.clear(), links_.clear();
  width_ = at(kinematics.width()), held_slide_ = 0, slides_anywhere_ = false;
  poses_.resize(links + kinematics.joints().size());
  bounds_.resize(poses_.size()), errors_.resize(links);
  is_possible_ = false, kinematics_ = kinematics.id();
  const auto place_of = [&](int joint) {
    if (joint < 0) return kWorld;
    const int home = order.home[at(joint)];
    return home < 0 ? static_cast<int>(links) + joint : home;
  };
  for (const int i : order.joints) {
    const Kinematics::Joint& joint = kinematics.joints()[at(i)];
    if (!can_be_posed(joint)) return;
    add_joint(joint, place_of(joint.parent), place_of(i));
  }
  for (const int i : order.links) {
    const Kinematics::Link& link = kinematics.links()[at(i)];
    add({place_of(link.joint), i, link.form, {}, Motion::kNone, {}, {}}, link.placement, nullptr);
  }
  for (std::size_t i = 0; i < links; ++i) {
    if (needed[i] != 0) links_.push_back(i);
  }
  bound_errors(held_slide_);
  is_possible_ = std::all_of(links_.begin(), links_.end(), [&](std::size_t i) { return errors_[i].turn <= kMostTurn; });
}

void FloatLinkPoser::add_joint(const Kinematics::Joint& joint, int parent, int to) {
  const JointValue& value = joint.values[0];
  const std::size_t place = steps_.size();
  if (!joint.held) read_.push_back(place), slides_anywhere_ |= joint.kind == JointKind::kSlide;
  switch (joint.kind) {
    case JointKind::kTurnX:
      add({parent, to, joint.form, {}, Motion::kTurnX, {}, value}, joint.placement, nullptr);
      break;
    case JointKind::kTurnY:
      add({parent, to, joint.form, {}, Motion::kTurnY, {}, value}, joint.placement, nullptr);
      break;
    case JointKind::kTurnZ:
      add({parent, to, joint.form, {}, Motion::kTurnZ, {}, value}, joint.placement, nullptr);
      break;
    case JointKind::kSlide:
      add({parent, to, joint.form, {}, Motion::kSlide, {}, value}, joint.placement, joint.axis);
      break;
    default: {
      const Rigid frame = frame_about(joint.axis), back = inverse_rotation(frame);
      const PlacementForm form = PlacementForm::kGeneral;
      add({parent, kInHand, form, {}, Motion::kTurnZ, {}, value}, turned(joint.placement, frame), nullptr);
      add({kInHand, to, form, {}, Motion::kNone, {}, {}}, back, nullptr);
    }
  }
  if (!joint.held) return;
  if (joint.kind == JointKind::kSlide) {
    slides_[place] = in_all(static_cast<float>(joint.held_values[0]));
    held_slide_ = larger(held_slide_, std::fabs(joint.held_values[0]));
  } else {
    turns_[place] = {in_all(static_cast<float>(joint.held_values[1])),
                     in_all(static_cast<float>(joint.held_values[0]))};
  }
}

void FloatLinkPoser::add(Step step, const Rigid& placement, const double* axis) {
  FloatPoseError bound = step.parent == kWorld    ? FloatPoseError(placement)
                         : step.parent == kInHand ? in_hand_
                                                  : bounds_[at(step.parent)];
  if (step.parent != kWorld) bound.place(placement);
  if (step.motion == Motion::kSlide) {
    bound.slide(axis);
  } else if (step.motion != Motion::kNone) {
    bound.turn();
  }
  in_hand_ = bound;
  if (step.to != kInHand) bounds_[at(step.to)] = bound;
  for (std::size_t i = 0; i < step.placement.size(); ++i) step.placement[i] = static_cast<float>(placement.m[i]);
  for (std::size_t i = 0; axis != nullptr && i < step.axis.size(); ++i) step.axis[i] = static_cast<float>(axis[i]);
  steps_.push_back(step);
  turns_.emplace_back(), slides_.emplace_back();
}

void FloatLinkPoser::bound_errors(double slid) {
  for (const std::size_t i : links_) errors_[i] = bounds_[i].bound(slid);
}

bool FloatLinkPoser::read_values(const Lanes* q) {
  LaneMask fit = ~LaneMask{};
  Lanes slid = broadcast(held_slide_);
  bool slides = false;
  for (const std::size_t k : read_) {
    const auto& [column, multiplier, offset] = steps_[k].value;
    Lanes values[kBlockGroups];
    for (std::size_t group = 0; group < kBlockGroups; ++group) values[group] = q[group * width_ + at(column)];
    if (multiplier != 1 || offset != 0) {
      for (Lanes& value : values) value = multiplier * value + offset;
    }
    if (steps_[k].motion == Motion::kSlide) {
      slides = true;
      for (const Lanes value : values) slid = larger(absolute(value), slid), fit &= absolute(value) <= kLargestDistance;
      slides_[k] = joined_floats<kBlockStates>(values, 1);
    } else {
      for (const Lanes value : values) fit &= are_reducible(value);
      turns_[k] = float_sincos(values);
    }
  }
  if (slides) {
    double most = 0;
    for (int lane = 0; lane < kLanes; ++lane) most = larger(most, slid[lane]);
    bound_errors(most);
  }
  return bits(~fit) == 0;
}

// All values are read first, as in LinkPoser::pose.
bool FloatLinkPoser::pose(const Lanes* q) {
  if (!read_values(q)) return false;
  FloatPose pose;
  int posed = kInHand;  // whose pose that is
  for (std::size_t k = 0; k < steps_.size(); ++k) {
    const Step& step = steps_[k];
    if (step.parent == kWorld) {
#pragma GCC unroll 12
      for (std::size_t i = 0; i < 12; ++i) pose.m[i] = in_all(step.placement[i]);
    } else {
      if (step.parent != kInHand && step.parent != posed) pose = poses_[at(step.parent)];
      place(pose.m.data(), step.form, step.placement.data());
    }
    switch (step.motion) {
      case Motion::kNone:
        break;
      case Motion::kTurnX:
        turn_columns<1, 2>(pose.m.data(), turns_[k].cos, turns_[k].sin);
        break;
      case Motion::kTurnY:
        turn_columns<2, 0>(pose.m.data(), turns_[k].cos, turns_[k].sin);
        break;
      case Motion::kTurnZ:
        turn_columns<0, 1>(pose.m.data(), turns_[k].cos, turns_[k].sin);
        break;
      case Motion::kSlide:
        slide(pose, step.axis, slides_[k]);
        break;
    }
    if (step.to != kInHand) poses_[at(step.to)] = pose;
    posed = step.to;
  }
  return true;
}

}  // namespace plannercheck
