// States along a piece of a planar motion, posed one in each lane and kept by rows, as in motion_grid.hpp.
#pragma once

#include <array>
#include <vector>

#include "planar/kinematics_2d.hpp"
#include "planar/motion_bounds_2d.hpp"
#include "planar/swept_distance_2d.hpp"

namespace plannercheck {

// The length of a row: room for all states, read in whole lanes from any of them.
inline constexpr std::size_t kPlanarRow = 48;

class PlanarGrid {
 public:
  PlanarGrid(const std::vector<PlanarLink>& links, std::size_t width, const std::vector<PlanarGeometryObject>& bodies,
             const std::vector<std::int32_t>& movers)
      : links_(links),
        bodies_(bodies),
        movers_(movers),
        columns_(width),
        rows_(4 * kPlanarRow * links.size()),
        centres_(2 * kPlanarRow * bodies.size()),
        boxes_(bodies.size()) {}

  // Poses intervals + 1 states from `from` to `to`, parameters of the piece.
  void place(const double* q0, const double* q1, const PlanarPiece& piece, double from, double to, int intervals);
  // A configuration for each of kLanes parameters of the piece.
  void configure(const double* q0, const double* q1, const PlanarPiece& piece, Lanes s);
  const std::vector<Lanes>& columns() const { return columns_; }

  std::size_t intervals() const { return intervals_; }
  double parameter(std::size_t state) const { return s_[state]; }
  // The length of the longest interval, rounded up, since parameters are rounded.
  double step() const { return (s_[intervals_] - s_[0]) / static_cast<double>(intervals_) * (1 + 1e-9) + 0x1p-50; }

  // Rows x, y of a body's centre, and a box around them: least x, y, largest x, y.
  const double* centre(std::int32_t body) const { return &centres_[at(body) * 2 * kPlanarRow]; }
  const std::array<double, 4>& box(std::int32_t body) const { return boxes_[at(body)]; }
  // The pose of a link at a state; the world's if there is no link.
  PlanarPlace place_of(std::int32_t link, std::size_t state) const;

 private:
  const std::vector<PlanarLink>& links_;
  const std::vector<PlanarGeometryObject>& bodies_;
  const std::vector<std::int32_t>& movers_;
  std::size_t intervals_ = 1;
  std::array<double, kPlanarRow> s_{};
  std::vector<Lanes> columns_;
  std::vector<PlanarLinkLanes> lanes_;
  std::vector<double> rows_, centres_;  // rows cos, sin, x, y of each link; x, y of each body
  std::vector<std::array<double, 4>> boxes_;
};

}  // namespace plannercheck
