// On which intervals of a motion's grid a body may be near a part of a set that stands still.
//
// In: the grid, what filters know of it, groups of bodies. Out: intervals. Idea: a box around the body at both ends of
// an interval is held against the set's tree, first of all intervals at once, and of halves where that is near; bodies
// of one link are looked at together before.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/part_groups.hpp"
#include "motions/motion_filters.hpp"
#include "motions/motion_grid.hpp"
#include "motions/swept_boxes.hpp"

namespace plannercheck {

// The intervals of a motion's first grid on which some body of a group may be near parts of its set.
struct GroupIntervals {
  std::uint64_t motion = 0;
  unsigned near = 0;
};

class PartScreen {
 public:
  // `room`: parts that are so much further away than the pair's inflation radii are left out, m.
  PartScreen(const MotionModel& model, const PartGroups& groups, const MotionFilters& filters, MotionGrid& grid,
             double room)
      : model_(model), groups_(groups), filters_(filters), grid_(grid), room_(room) {}

  // For a pair with a set of parts, of the intervals `near`.
  unsigned near(const CertifiedPair& pair, unsigned near) const;
  // For all bodies of the pair's group, if it has one, on the first grid of a motion; `known` keeps what was found.
  unsigned near_group(std::int32_t index, std::uint64_t motion, std::vector<GroupIntervals>& known) const;

 private:
  const MotionModel& model_;
  const PartGroups& groups_;
  const MotionFilters& filters_;
  MotionGrid& grid_;
  double room_;

  unsigned near_boxes(std::int32_t mover, std::int32_t set, const FrameBox& box, unsigned near, double apart) const;
};

}  // namespace plannercheck
