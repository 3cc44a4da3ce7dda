#include "motions/motion_grid.hpp"

#include <algorithm>

#include "robots/kinematics_lanes.hpp"

namespace plannercheck {

MotionGrid::MotionGrid(const std::vector<GeometryObject>& bodies, std::size_t width, std::size_t links)
    : bodies_(&bodies),
      columns_(width * kGridRow),
      links_(links * 12 * kGridRow),
      poses_(bodies.size() * 12 * kGridRow),
      centres_(bodies.size() * 3 * kGridRow),
      posed_(bodies.size(), 0),
      needed_(links),
      q_(width),
      link_lanes_(links * 12) {
  for (const GeometryObject& body : bodies) centre_on_link_.push_back(body.placement.apply(body.body->centre));
}

void MotionGrid::choose(const std::vector<std::int32_t>& bodies, const std::vector<std::int32_t>& frames) {
  chosen_ = bodies;
  std::fill(needed_.begin(), needed_.end(), 0);
  for (const std::int32_t body : bodies) needed_[at((*bodies_)[at(body)].link)] = 1;
  for (const std::int32_t link : frames) needed_[at(link)] = 1;
  needed_links_.clear();
  for (std::size_t link = 0; link < needed_.size(); ++link) {
    if (needed_[link] != 0) needed_links_.push_back(static_cast<std::int32_t>(link));
  }
}

void MotionGrid::place(const Kinematics& kinematics, const ConfigurationPath& path, double from, double to,
                       int intervals) {
  ++grid_;
  poser_.begin(kinematics, needed_.data());
  intervals_ = static_cast<std::size_t>(intervals);
  const std::size_t filled = (intervals_ + kStep) / kStep * kStep;
  for (std::size_t i = 0; i < filled; ++i) {
    const double part = static_cast<double>(i) / intervals;
    t_[i] = i < intervals_ ? from + part * (to - from) : to;
  }
  path.at(t_.data(), filled, kGridRow, columns_.data());
  for (std::size_t first = 0; first < filled; first += kStep) pose_lanes(first);
}

void MotionGrid::pose_lanes(std::size_t first) {
  for (std::size_t c = 0; c < q_.size(); ++c) q_[c] = load_lanes(&columns_[c * kGridRow + first]);
  poser_.pose(q_.data(), link_lanes_.data());
  for (const std::int32_t link : needed_links_) {
    for (std::size_t k = at(link) * 12; k < at(link) * 12 + 12; ++k)
      store_lanes(&links_[k * kGridRow + first], link_lanes_[k]);
  }
  for (const std::int32_t body : chosen_) pose_centre(body, first);
}

void MotionGrid::pose_centre(std::int32_t body, std::size_t first) {
  const Vec3 c = centre_on_link_[at(body)];
  const Lanes* m = &link_lanes_[at((*bodies_)[at(body)].link) * 12];
  double* out = &centres_[at(body) * 3 * kGridRow + first];
  for (std::size_t row = 0; row < 3; ++row) {
    const Lanes* r = m + 4 * row;
    store_lanes(out + row * kGridRow, (r[0] * c.x + r[1] * c.y) + (r[2] * c.z + r[3]));
  }
}

const double* MotionGrid::poses(std::int32_t body) {
  double* out = &poses_[at(body) * 12 * kGridRow];
  if (posed_[at(body)] == grid_) return out;
  posed_[at(body)] = grid_;
  const GeometryObject& object = (*bodies_)[at(body)];
  const auto& p = object.placement.m;
  for (std::size_t first = 0; first <= intervals_; first += kStep) {
    for (std::size_t row = 0; row < 12; row += 4) {
      const double* from = link(object.link) + row * kGridRow + first;
      const Lanes a = load_lanes(from), b = load_lanes(from + kGridRow), c = load_lanes(from + 2 * kGridRow);
      for (std::size_t col = 0; col < 4; ++col) {
        const Lanes sum = (a * p[col] + b * p[col + 4]) + c * p[col + 8];
        store_lanes(out + (row + col) * kGridRow + first, col == 3 ? sum + load_lanes(from + 3 * kGridRow) : sum);
      }
    }
  }
  return out;
}

Pose MotionGrid::pose(std::int32_t body, std::size_t state) {
  const GeometryObject& object = (*bodies_)[at(body)];
  if (object.link < 0) return object.placement;
  const double* rows = poses(body);
  Pose out;
  for (std::size_t k = 0; k < 12; ++k) out.m[k] = rows[k * kGridRow + state];
  return out;
}

FrameTurn MotionGrid::turn(std::int32_t frame, std::size_t state) const {
  FrameTurn out;
  if (frame < 0) return out;
  const double* rows = link(frame) + state;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t col = 0; col < 3; ++col) out.m[3 * row + col] = rows[(4 * row + col) * kGridRow];
  }
  return out;
}

}  // namespace plannercheck
