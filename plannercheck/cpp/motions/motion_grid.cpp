#include "motions/motion_grid.hpp"

#include <algorithm>

#include "robots/kinematics_lanes.hpp"

namespace plannercheck {
namespace {

Lanes first_states() {
  Lanes out{};
  for (int k = 0; k < kLanes; ++k) out[k] = k;
  return out;
}

Pose pose_in(const Lanes* lanes, std::size_t state) {
  Pose out;
  for (std::size_t k = 0; k < 12; ++k) out.m[k] = lanes[k][state % kStep];
  return out;
}

}  // namespace

MotionGrid::MotionGrid(const std::vector<GeometryObject>& bodies, std::size_t width, std::size_t links)
    : bodies_(&bodies),
      link_count_(links),
      mover_of_(bodies.size(), -1),
      columns_(width * kGridRow / kStep),
      links_(kPosedStates / kStep * links * 12),
      q_(width) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].link < 0) continue;
    mover_of_[b] = static_cast<std::int32_t>(centre_on_link_.size());
    centre_on_link_.push_back(bodies[b].placement.apply(bodies[b].body->centre));
  }
  const std::size_t movers = centre_on_link_.size();
  centres_.resize(movers * 3 * kGridRow / kStep);
  poses_.resize(movers * kPosedStates / kStep * 12);
  posed_.resize(movers), centred_.resize(movers);
}

MotionGrid::Choice MotionGrid::choice(const Kinematics& kinematics, const std::vector<std::int32_t>& bodies,
                                      const std::vector<std::int32_t>& frames) const {
  Choice out;
  std::vector<unsigned char> needed(link_count_);
  for (const std::int32_t body : bodies) needed[at((*bodies_)[at(body)].link)] = 1;
  for (const std::int32_t link : frames) needed[at(link)] = 1;
  out.poser.begin(kinematics, needed.data());
  return out;
}

void MotionGrid::place(Choice& choice, const Path& path, double from, double to, int intervals) {
  ++grid_;
  intervals_ = static_cast<std::size_t>(intervals);
  const std::size_t filled = (intervals_ + kStep) / kStep * kStep;
  Lanes state = first_states();
  for (std::size_t i = 0; i < filled; i += kStep, state = state + static_cast<double>(kStep)) {
    const Lanes t = from + state / static_cast<double>(intervals) * (to - from);
    store_lanes(&t_[i], state < static_cast<double>(intervals) ? t : broadcast(to));
  }
  step_ = (t_[intervals_] - t_[0]) / static_cast<double>(intervals_) * (1 + 1e-9) + 0x1p-50;
  path.at(t_.data(), filled, kGridRow, reinterpret_cast<double*>(columns_.data()));
  for (std::size_t first = 0; first < filled; first += kStep) {
    for (std::size_t c = 0; c < q_.size(); ++c) q_[c] = columns_[(c * kGridRow + first) / kStep];
    choice.poser.pose(q_.data(), &links_[first / kStep * link_count_ * 12]);
  }
}

void MotionGrid::pose_point(std::size_t link, Vec3 p, double* rows) const {
  for (std::size_t first = 0; first <= intervals_; first += kStep) {
    const Lanes* const m = links_at(first) + link * 12;
#pragma GCC unroll 3
    for (std::size_t row = 0; row < 3; ++row) {
      const Lanes* const r = m + 4 * row;
      store_lanes(rows + row * kGridRow + first, (r[0] * p.x + r[1] * p.y) + (r[2] * p.z + r[3]));
    }
  }
}

const Lanes* MotionGrid::posed(std::int32_t body) {
  Lanes* const all = &poses_[mover(body) * kPosedStates / kStep * 12];
  if (posed_[mover(body)] == grid_) return all;
  posed_[mover(body)] = grid_;
  const GeometryObject& object = (*bodies_)[at(body)];
  const auto& p = object.placement.m;
  Lanes* out = all;
  for (std::size_t first = 0; first <= intervals_; first += kStep, out += 12) {
    const Lanes* const m = link(object.link, first);
    for (std::size_t row = 0; row < 12; row += 4) {
      for (std::size_t col = 0; col < 4; ++col) {
        const Lanes sum = (m[row] * p[col] + m[row + 1] * p[col + 4]) + m[row + 2] * p[col + 8];
        out[row + col] = col == 3 ? sum + m[row + 3] : sum;
      }
    }
  }
  return all;
}

Pose MotionGrid::pose(std::int32_t body, std::size_t state) {
  const GeometryObject& object = (*bodies_)[at(body)];
  if (object.link < 0) return object.placement;
  return pose_in(poses(body, state), state);
}

Pose MotionGrid::link_pose(std::int32_t link, std::size_t state) const {
  return pose_in(this->link(link, state), state);
}

FrameTurn MotionGrid::turn(std::int32_t frame, std::size_t state) const {
  FrameTurn out;
  if (frame < 0) return out;
  const Lanes* const lanes = link(frame, state);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t col = 0; col < 3; ++col) out.m[3 * row + col] = lanes[4 * row + col][state % kStep];
  }
  return out;
}

}  // namespace plannercheck
