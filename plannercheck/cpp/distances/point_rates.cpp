#include "distances/point_rates.hpp"

#include <algorithm>
#include <array>

#include "robots/state_poser.hpp"

namespace plannercheck {
namespace {

std::vector<std::int32_t> joints_to(const Kinematics& kinematics, std::int32_t link) {
  std::vector<std::int32_t> out;
  if (link < 0) return out;
  for (int joint = kinematics.links()[at(link)].joint; joint >= 0; joint = kinematics.joints()[at(joint)].parent) {
    out.push_back(joint);
  }
  std::reverse(out.begin(), out.end());
  return out;
}

Vec3 column_of(const PoseColumns& pose, std::size_t k) { return {pose.at(0, k), pose.at(1, k), pose.at(2, k)}; }

// A vector of the world along the axes of a joint's frame.
std::array<double, 3> in_frame(const PoseColumns& frame, Vec3 v) {
  return {dot(column_of(frame, 0), v), dot(column_of(frame, 1), v), dot(column_of(frame, 2), v)};
}

double along(const double* axis, const std::array<double, 3>& v) {
  return axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
}

class Adding {
 public:
  Adding(const Kinematics::Joint& joint, const Tangent& tangent, double sign, double* gradient)
      : joint_(joint), tangent_(tangent), sign_(sign), gradient_(gradient) {}

  // A unit of the joint's value k changes the distance by `rate`.
  void value(std::size_t k, double rate) {
    const JointValue& value = joint_.values[k];
    if (value.column < 0) return;
    const std::int32_t place = tangent_.places[at(value.column)];
    if (place >= 0) gradient_[at(place)] += sign_ * value.multiplier * rate;
  }
  void turn_of_quaternion(std::size_t first, const std::array<double, 3>& turns) {
    for (std::size_t k = 0; k < 3; ++k) value(first + k, turns[k]);
  }

 private:
  const Kinematics::Joint& joint_;
  const Tangent& tangent_;
  double sign_;
  double* gradient_;
};

void add_joint(const Kinematics::Joint& joint, const PoseColumns& frame, Vec3 point, Vec3 normal, Adding to) {
  const Vec3 lever = point - column_of(frame, 3);
  const auto slides = in_frame(frame, normal), turns = in_frame(frame, cross(lever, normal));
  switch (joint.kind) {
    case JointKind::kTurnX:
      return to.value(0, turns[0]);
    case JointKind::kTurnY:
      return to.value(0, turns[1]);
    case JointKind::kTurnZ:
      return to.value(0, turns[2]);
    case JointKind::kTurnAxis:
      return to.value(0, along(joint.axis, turns));
    // The sine's multiplier says in which sense the pair turns.
    case JointKind::kUnitTurnX:
      return to.value(1, turns[0]);
    case JointKind::kUnitTurnY:
      return to.value(1, turns[1]);
    case JointKind::kUnitTurnZ:
      return to.value(1, turns[2]);
    case JointKind::kUnitTurnAxis:
      return to.value(1, along(joint.axis, turns));
    case JointKind::kSlide:
      return to.value(0, along(joint.axis, slides));
    case JointKind::kPlanar:
      to.value(0, slides[0]), to.value(1, slides[1]);
      return to.value(3, turns[2]);
    case JointKind::kBall:
      return to.turn_of_quaternion(0, turns);
    case JointKind::kFree:
      for (std::size_t k = 0; k < 3; ++k) to.value(k, slides[k]);
      return to.turn_of_quaternion(3, turns);
  }
}

}  // namespace

CarryingJoints carrying_joints(const Kinematics& kinematics, std::int32_t link_a, std::int32_t link_b) {
  const std::vector<std::int32_t> a = joints_to(kinematics, link_a), b = joints_to(kinematics, link_b);
  const auto [from_a, from_b] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  return {{from_a, a.end()}, {from_b, b.end()}};
}

void add_gradient(const Kinematics& kinematics, const StatePoser& posed, const CarryingJoints& joints,
                  const Tangent& tangent, Vec3 point, Vec3 normal, double* gradient) {
  const auto add = [&](const std::vector<std::int32_t>& some, double sign) {
    for (const std::int32_t k : some) {
      const Kinematics::Joint& joint = kinematics.joints()[at(k)];
      if (!joint.held) add_joint(joint, posed.of_joint(k), point, normal, {joint, tangent, sign, gradient});
    }
  };
  add(joints.of_a, 1), add(joints.of_b, -1);
}

}  // namespace plannercheck
