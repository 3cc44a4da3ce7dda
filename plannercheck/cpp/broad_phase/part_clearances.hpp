// Look-ups in clearance grids, for bodies on links against static sets of parts.
//
// In: bodies on links and in the world. Out: a set's grid, made at its first use; and balls that together hold a body,
// in its link's frame.
#pragma once

#include <cstdint>
#include <vector>

#include "bodies/lazy_value.hpp"
#include "broad_phase/clearance_grid.hpp"
#include "broad_phase/geometry_object.hpp"

namespace plannercheck {

class PartClearances {
 public:
  // `reach`: roughly how far the bodies on links come from the world's origin, m. Bodies further away are never clear.
  PartClearances(std::vector<GeometryObject> bodies, double reach);

  // Where to look for a pair.
  struct Look {
    const ClearanceGrid* grid = nullptr;  // none if nothing can be said of the pair
    const std::vector<SmallBall>* balls = nullptr;
    std::int32_t link = -1;
  };
  // The bodies of a pair, in either order.
  Look look(std::int32_t a, std::int32_t b) const;

  // Whether the hull, at its link's pose, is surely further than the margin from all parts, whose radii are counted.
  static bool is_clear(const Look& look, const std::array<double, 12>& link, double margin);
  // As is_clear, at a pose in each lane: a bit each. `link`: the twelve numbers of a pose.
  static unsigned clear_lanes(const Look& look, const Lanes* link, double margin);

 private:
  std::vector<GeometryObject> bodies_;
  double reach_;
  std::vector<LazyValue<ClearanceGrid>> grids_;           // by body
  std::vector<LazyValue<std::vector<SmallBall>>> balls_;  // by body: on its link

  const ClearanceGrid& grid(std::int32_t set) const;
  const std::vector<SmallBall>& balls_on_link(std::int32_t body) const;
};

}  // namespace plannercheck
