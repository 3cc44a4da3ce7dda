// Whether, and on which intervals of a motion's grid, a body may be near a part of a static set.
//
// In: the grid, the filters' data of it, groups of bodies. Out: verdicts, or intervals. Idea: a box around the body at
// all states is tested against the set's tree, then, if it is near, boxes at halves of the states; bodies of one link
// are tested together first.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase/part_groups.hpp"
#include "motions/motion_filters.hpp"
#include "motions/motion_grid.hpp"
#include "motions/swept_boxes.hpp"

namespace plannercheck {

// Whether all bodies of a group stay far from their set on a motion's first grid.
struct MotionGroupLook {
  std::uint64_t motion = 0;
  bool is_far = false;
};

class PartScreen {
 public:
  // `room`: parts that are so much further away than the pair's inflation radii are left out, m.
  PartScreen(const MotionModel& model, const PartGroups& groups, const MotionFilters& filters, MotionGrid& grid,
             double room)
      : model_(model), groups_(groups), filters_(filters), grid_(grid), room_(room) {}

  // For all bodies of the pair's group, if it has one, on the first grid of a motion; `known` keeps what was found.
  bool group_is_far(std::int32_t index, std::uint64_t motion, std::vector<MotionGroupLook>& known) const;
  // For a pair with a set of parts, of the intervals `near`.
  unsigned near(const CertifiedPair& pair, unsigned near) const;

 private:
  const MotionModel& model_;
  const PartGroups& groups_;
  const MotionFilters& filters_;
  MotionGrid& grid_;
  double room_;

  std::size_t middle() const { return (grid_.intervals() + 1) / 2; }
  PosedPolytope posed(std::int32_t set) const;
};

}  // namespace plannercheck
