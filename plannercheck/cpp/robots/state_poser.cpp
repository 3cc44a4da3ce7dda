#include "robots/state_poser.hpp"

#include <algorithm>

#include "math/sincos.hpp"
#include "math/vec.hpp"
#include "robots/joint_motions.hpp"

namespace plannercheck {
namespace {

constexpr int kStatePose = static_cast<int>(StatePoser::kStride);
constexpr int kTranslation = 3;  // the column

// Lanes `i`, `j` and so on of `yes`, the others of `no`.
template <int... lanes>
Double4 lanes_of(Double4 yes, Double4 no) {
  Double4Mask mask{};
  ((mask[lanes] = -1), ...);
  return mask ? yes : no;
}

// Adding this keeps the sign of zeros; adding 0 would not.
constexpr Double4 kSignedNothing = {-0.0, -0.0, -0.0, -0.0};

// A row of a pose times a placement, all columns.
Double4 row_on(Double4 row, const Double4 (&p)[3]) {
  Double4 shift = kSignedNothing;
  shift[kTranslation] = row[kTranslation];
  return row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + shift;
}

// The same where the placement's rotation keeps one axis: that column stays, and the others are sums of two products.
template <int axis>
Double4 turned_row(Double4 row, const Double4 (&p)[3]) {
  constexpr int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const Double4 two = row[i] * p[i] + row[j] * p[j];
  return lanes_of<axis>(row, lanes_of<i, j>(two, row_on(row, p)));
}

// A row times the rotation by the angle of (cos, sin) that takes column `from` towards column `to`.
template <int from, int to>
Double4 with_turned_columns(Double4 row, double cos, double sin) {
  constexpr int other[4] = {from == 0 ? to
                            : to == 0 ? from
                                      : 0,
                            from == 1 ? to
                            : to == 1 ? from
                                      : 1,
                            from == 2 ? to
                            : to == 2 ? from
                                      : 2,
                            kTranslation};
  Double4 sines{};
  sines[from] = sin, sines[to] = -sin;
  const Double4 swapped = shuffled<other[0], other[1], other[2], other[3]>(row, row);
  return lanes_of<from, to>(cos * row + sines * swapped, row);
}

Double4 rotated(Double4 row, const std::array<double, 9>& r) {
  const Double4 x{r[0], r[1], r[2], 0}, y{r[3], r[4], r[5], 0}, z{r[6], r[7], r[8], 0};
  return lanes_of<kTranslation>(row, row[0] * x + row[1] * y + row[2] * z);
}

Double4 slid(Double4 row, double x, double y, double z) {
  row[kTranslation] = row[0] * x + row[1] * y + row[2] * z + row[kTranslation];
  return row;
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
  steps_.clear(), angles_.clear();
  const int links = kinematics.link_count();
  const auto place = [&](int joint) {
    if (joint < 0) return -1;
    const int home = order.home[static_cast<std::size_t>(joint)];
    return kStatePose * (home < 0 ? links + joint : home);
  };
  for (const int i : order.joints) {
    const auto& joint = kinematics.joints()[static_cast<std::size_t>(i)];
    add(place(joint.parent), place(i), joint.placement, joint.form, &joint);
  }
  for (const int i : order.links) {
    const auto& link = kinematics.links()[static_cast<std::size_t>(i)];
    add(place(link.joint), kStatePose * i, link.placement, link.form, nullptr);
  }
  poses_.resize((at(links) + kinematics.joints().size()) * kStride);
  const std::size_t turns = (angles_.size() + kLanes - 1) / kLanes * kLanes;
  cos_.resize(turns), sin_.resize(turns);
}

void StatePoser::add(int parent, int to, const Rigid& placement, PlacementForm form, const Kinematics::Joint* joint) {
  Step step{parent, to, form, {}, joint, -1};
  for (int k = 0; k < 3; ++k) {
    const Double4 row = load_double4(placement.m + 4 * k);
    step.placement.row[k] = parent < 0 ? spread(row) : row;
  }
  if (joint != nullptr && !joint->held && is_angle(joint->kind)) {
    step.turn = static_cast<int>(angles_.size());
    angles_.push_back(joint->values[0]);
  }
  steps_.push_back(step);
}

void StatePoser::take_turns(const double* q) {
  for (std::size_t first = 0; first < angles_.size(); first += kLanes) {
    Lanes angle{};
    const std::size_t count = std::min<std::size_t>(kLanes, angles_.size() - first);
    for (std::size_t k = 0; k < count; ++k) angle[k] = number_of(angles_[first + k], q);
    const SinCos found = sincos(angle);
    store_lanes(&cos_[first], found.cos), store_lanes(&sin_[first], found.sin);
  }
}

inline StatePoser::Rows StatePoser::placed(const Rows& parent, const Rows& placement, PlacementForm form) {
  const auto& p = placement.row;
  const auto by_rows = [&](auto of) { return Rows{{of(parent.row[0]), of(parent.row[1]), of(parent.row[2])}}; };
  switch (form) {
    case PlacementForm::kIdentity:
      return parent;
    case PlacementForm::kShift:
      return by_rows([&](Double4 row) { return lanes_of<0, 1, 2>(row, row_on(row, p)); });
    case PlacementForm::kTurnX:
      return by_rows([&](Double4 row) { return turned_row<0>(row, p); });
    case PlacementForm::kTurnY:
      return by_rows([&](Double4 row) { return turned_row<1>(row, p); });
    case PlacementForm::kTurnZ:
      return by_rows([&](Double4 row) { return turned_row<2>(row, p); });
    case PlacementForm::kGeneral:
      return by_rows([&](Double4 row) { return row_on(row, p); });
  }
  return parent;
}

inline void StatePoser::move(const Step& step, const double* q, Rows& pose) const {
  const Kinematics::Joint& joint = *step.joint;
  const auto each = [&](auto of) {
    for (Double4& row : pose.row) row = of(row);
  };
  double values[7];
  if (step.turn >= 0) {
    values[0] = cos_[at(step.turn)], values[1] = sin_[at(step.turn)];
  } else if (joint.held) {
    std::transform(joint.held_values, joint.held_values + 7, values, spread<double>);
  } else {
    for (int k = 0; k < value_count(joint.kind); ++k) values[k] = number_of(joint.values[k], q);
  }
  const double *const v = values, *const axis = joint.axis;
  switch (joint.kind) {
    case JointKind::kTurnX:
    case JointKind::kUnitTurnX:
      return each([&](Double4 row) { return with_turned_columns<1, 2>(row, v[0], v[1]); });
    case JointKind::kTurnY:
    case JointKind::kUnitTurnY:
      return each([&](Double4 row) { return with_turned_columns<2, 0>(row, v[0], v[1]); });
    case JointKind::kTurnZ:
    case JointKind::kUnitTurnZ:
      return each([&](Double4 row) { return with_turned_columns<0, 1>(row, v[0], v[1]); });
    case JointKind::kTurnAxis:
    case JointKind::kUnitTurnAxis:
      return each([&, turn = turn_about_axis(axis, v[0], v[1])](Double4 row) { return rotated(row, turn); });
    case JointKind::kSlide:
      return each([&](Double4 row) { return slid(row, v[0] * axis[0], v[0] * axis[1], v[0] * axis[2]); });
    case JointKind::kPlanar:
      each([&](Double4 row) { return slid(row, v[0], v[1], 0); });
      return each([&](Double4 row) { return with_turned_columns<0, 1>(row, v[2], v[3]); });
    case JointKind::kBall:
      return each([&, turn = turn_of_quaternion(v)](Double4 row) { return rotated(row, turn); });
    case JointKind::kFree:
      each([&](Double4 row) { return slid(row, v[0], v[1], v[2]); });
      return each([&, turn = turn_of_quaternion(v + 3)](Double4 row) { return rotated(row, turn); });
  }
}

const double* StatePoser::pose(const double* q) {
  take_turns(q);
  for (const Step& step : steps_) {
    Rows pose = step.placement;
    if (step.parent >= 0) {
      const double* const parent = poses_.data() + step.parent;
      pose = placed({{load_double4(parent), load_double4(parent + 4), load_double4(parent + 8)}}, step.placement,
                    step.form);
    }
    if (step.joint != nullptr) move(step, q, pose);
    for (int k = 0; k < 3; ++k) store_double4(poses_.data() + step.to + 4 * k, pose.row[k]);
  }
  return poses_.data();
}

}  // namespace plannercheck
