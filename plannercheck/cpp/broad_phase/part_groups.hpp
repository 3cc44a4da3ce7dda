// Bodies of one link that are tested against the same set of parts: if no part is near a box around all of them, all
// are apart from the set.
//
// In: bodies and pairs. Out: groups of at least two pairs, each with a box in the frame of its first pair's body.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "broad_phase/geometry_object.hpp"

namespace plannercheck {

struct PartGroup {
  std::int32_t first = -1;            // of its pairs
  std::int32_t mover = -1, set = -1;  // the body in whose frame the box is, and the set
  std::vector<std::int32_t> pairs;
  Vec3 low, high;               // the box
  double inflation_radius = 0;  // the largest of all
};

struct PartGroups {
  std::vector<PartGroup> groups;
  std::vector<std::int32_t> of_pair;  // the group of each pair, or −1
};

// How far from the box, at a computed pose of the body in whose frame it is, others of the group may be at theirs.
double posing_room(const Pose& mover);

PartGroups part_groups(const std::vector<GeometryObject>& bodies,
                       const std::vector<std::array<std::int32_t, 2>>& pairs);

}  // namespace plannercheck
