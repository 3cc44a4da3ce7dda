// States along a motion, posed one in each lane: a row for each number of a pose, a column for each state.
//
// In: a path, the bodies on links, an interval of parameters. Out: centres and poses of the bodies at its states. Idea:
// intervals between states are tested in lanes as well, by loading a row at a state and at the next one.
#pragma once

#include <array>
#include <vector>

#include "checking/checker.hpp"
#include "math/simd.hpp"
#include "motions/configuration_path.hpp"
#include "motions/swept_distance.hpp"
#include "robots/kinematics_lanes.hpp"

namespace plannercheck {

inline constexpr std::size_t kStep = static_cast<std::size_t>(kLanes);  // states that are posed at once

// The length of a row: room for all states, read in whole lanes from any of them.
inline constexpr std::size_t kGridRow = 40;

class MotionGrid {
 public:
  MotionGrid(const std::vector<GeometryObject>& bodies, std::size_t width, std::size_t links);

  // Chooses what the next grids pose: bodies that move, and links that serve as frames.
  void choose(const std::vector<std::int32_t>& bodies, const std::vector<std::int32_t>& frames);

  // Poses intervals + 1 states from `from` to `to`.
  void place(const Kinematics& kinematics, const ConfigurationPath& path, double from, double to, int intervals);

  std::size_t intervals() const { return intervals_; }
  double parameter(std::size_t state) const { return t_[state]; }
  // The length of the longest interval, rounded up, since parameters are rounded.
  double step() const { return (t_[intervals_] - t_[0]) / static_cast<double>(intervals_) * (1 + 1e-9) + 0x1p-50; }

  // Rows x, y, z of a body's centre; static bodies have none.
  const double* centre(std::int32_t body) const { return &centres_[static_cast<std::size_t>(body) * 3 * kGridRow]; }
  // Twelve rows of a body's pose, computed on first use.
  const double* poses(std::int32_t body);
  // Twelve rows of a link's pose.
  const double* link(std::int32_t link) const { return &links_[static_cast<std::size_t>(link) * 12 * kGridRow]; }

  Pose pose(std::int32_t body, std::size_t state);
  FrameTurn turn(std::int32_t frame, std::size_t state) const;

 private:
  const std::vector<GeometryObject>* bodies_;
  std::size_t intervals_ = 1;
  std::array<double, kGridRow> t_{};
  std::vector<double> columns_, links_, poses_, centres_;
  std::vector<Vec3> centre_on_link_;
  std::vector<long> posed_;  // the grid for which a body's poses were computed
  long grid_ = 0;
  std::vector<unsigned char> needed_;
  std::vector<std::int32_t> chosen_, needed_links_;
  std::vector<Lanes> q_, link_lanes_;
  LinkPoser poser_;

  void pose_lanes(std::size_t first);
  void pose_centre(std::int32_t body, std::size_t first);
};

}  // namespace plannercheck
