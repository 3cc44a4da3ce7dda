// States along a motion, posed one in each lane: a row for each number of a pose, a column for each state.
//
// In: a path, the bodies on links, an interval of parameters. Out: centres and poses of the bodies at its states. Idea:
// intervals between states are tested in lanes as well, by loading a row at a state and at the next one.
#pragma once

#include <array>
#include <vector>

#include "checking/checker.hpp"
#include "math/simd.hpp"
#include "motions/path.hpp"
#include "motions/swept_distance.hpp"
#include "robots/kinematics_lanes.hpp"

namespace plannercheck {

inline constexpr std::size_t kStep = static_cast<std::size_t>(kLanes);  // states that are posed at once

// The length of a row: room for all states and one more, in whole lanes.
inline constexpr std::size_t kGridRow = 40;

// The number of states that are posed at most: kGridStates of adaptive_subdivision.hpp, in whole lanes.
inline constexpr std::size_t kPosedStates = 32;
static_assert(kPosedStates % kStep == 0 && kGridRow % kStep == 0);

class MotionGrid {
 public:
  MotionGrid(const std::vector<GeometryObject>& bodies, std::size_t width, std::size_t links);

  // What a grid poses: bodies that move, and links that serve as frames. Prepared for one kinematics, which has to
  // outlive it.
  struct Choice {
    LinkPoser poser;
  };
  Choice choice(const Kinematics& kinematics, const std::vector<std::int32_t>& bodies,
                const std::vector<std::int32_t>& frames) const;

  // Poses intervals + 1 states from `from` to `to`.
  void place(Choice& choice, const Path& path, double from, double to, int intervals);

  std::size_t intervals() const { return intervals_; }
  double parameter(std::size_t state) const { return t_[state]; }
  // The length of the longest interval, rounded up, since parameters are rounded.
  double step() const { return step_; }

  // Rows x, y, z of a body's centre, computed on first use; static bodies have none.
  const double* centre(std::int32_t body) {
    const std::size_t place = mover(body);
    double* const rows = reinterpret_cast<double*>(&centres_[place * 3 * kGridRow / kStep]);
    if (centred_[place] != grid_) {
      centred_[place] = grid_;
      pose_point(at((*bodies_)[at(body)].link), centre_on_link_[place], rows);
    }
    return rows;
  }
  // The twelve numbers of a body's pose at the states from `first` on, a multiple of kStep; computed on first use.
  const Lanes* poses(std::int32_t body, std::size_t first) { return posed(body) + first / kStep * 12; }
  // Writes rows x, y, z of a point of a link, given in the link's frame.
  void pose_point(std::size_t link, Vec3 point, double* rows) const;
  // The same for a link.
  const Lanes* link(std::int32_t link, std::size_t first) const { return links_at(first) + at(link) * 12; }
  // All links' at these states, as state_block.hpp has them.
  const Lanes* links_at(std::size_t first) const { return &links_[first / kStep * link_count_ * 12]; }

  Pose pose(std::int32_t body, std::size_t state);
  Pose link_pose(std::int32_t link, std::size_t state) const;
  FrameTurn turn(std::int32_t frame, std::size_t state) const;

 private:
  const std::vector<GeometryObject>* bodies_;
  std::size_t link_count_;
  std::size_t intervals_ = 1;
  double step_ = 1;
  std::array<double, kGridRow> t_{};
  std::vector<std::int32_t> mover_of_;    // a body's place among the bodies on links; others have no data
  std::vector<Lanes> columns_, centres_;  // rows of numbers, aligned to cache lines
  std::vector<Lanes> links_, poses_;      // poses: by state group, and by mover and state group
  std::vector<Vec3> centre_on_link_;
  std::vector<long> posed_, centred_;  // the grids for which a mover's poses and centre were computed
  long grid_ = 0;
  std::vector<Lanes> q_;

  std::size_t mover(std::int32_t body) const { return at(mover_of_[at(body)]); }
  const Lanes* posed(std::int32_t body);
};

}  // namespace plannercheck
