#include "planar/motion_grid_2d.hpp"

#include <algorithm>

#include "math/sincos.hpp"
#include "math/vec.hpp"

namespace plannercheck {

void PlanarGrid::configure(const double* q0, const double* q1, const PlanarPiece& piece, Lanes s) {
  const Lanes t = piece.from + s * (piece.to - piece.from);
  for (std::size_t c = 0; c < columns_.size(); ++c) columns_[c] = (1 - t) * q0[c] + t * q1[c];
  if (links_[0].joint != PlanarJoint::kFree) return;
  const Lanes heading = piece.heading + s * piece.turn;
  columns_[0] = piece.origin_x + s * piece.way_x;
  columns_[1] = piece.origin_y + s * piece.way_y;
  columns_[2] = heading;
  if (piece.arm_x == 0 && piece.arm_y == 0) return;
  const SinCos turn = sincos(heading);
  columns_[0] = columns_[0] + (turn.cos * piece.arm_x - turn.sin * piece.arm_y);
  columns_[1] = columns_[1] + (turn.sin * piece.arm_x + turn.cos * piece.arm_y);
}

void PlanarGrid::place(const double* q0, const double* q1, const PlanarPiece& piece, double from, double to,
                       int intervals) {
  intervals_ = static_cast<std::size_t>(intervals);
  for (std::size_t i = 0; i < kPlanarRow; ++i) {
    s_[i] = i < intervals_ ? from + (to - from) * (static_cast<double>(i) / intervals) : to;
  }
  for (std::size_t first = 0; first <= intervals_; first += kLanes) {
    configure(q0, q1, piece, load_lanes(&s_[first]));
    pose_planar_links(links_, columns_, lanes_);
    for (std::size_t k = 0; k < lanes_.size(); ++k) {
      double* row = &rows_[4 * kPlanarRow * k + first];
      for (const Lanes& lanes : {lanes_[k].cos, lanes_[k].sin, lanes_[k].x, lanes_[k].y}) {
        store_lanes(row, lanes);
        row += kPlanarRow;
      }
    }
    for (const std::int32_t mover : movers_) {
      const PlanarGeometryObject& body = bodies_[at(mover)];
      const PlanarLinkLanes& link = lanes_[at(body.link)];
      double* row = &centres_[2 * kPlanarRow * at(mover) + first];
      store_lanes(row, link.x + (link.cos * body.x - link.sin * body.y));
      store_lanes(row + kPlanarRow, link.y + (link.sin * body.x + link.cos * body.y));
    }
  }
  for (const std::int32_t mover : movers_) {
    const double *x = centre(mover), *y = x + kPlanarRow;
    const auto [least_x, largest_x] = std::minmax_element(x, x + intervals_ + 1);
    const auto [least_y, largest_y] = std::minmax_element(y, y + intervals_ + 1);
    boxes_[at(mover)] = {*least_x, *least_y, *largest_x, *largest_y};
  }
}

PlanarPlace PlanarGrid::place_of(std::int32_t link, std::size_t state) const {
  if (link < 0) return {};
  const double* row = &rows_[4 * kPlanarRow * at(link) + state];
  return {row[0], row[kPlanarRow], row[2 * kPlanarRow], row[3 * kPlanarRow]};
}

}  // namespace plannercheck
