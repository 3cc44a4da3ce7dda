#include "motions/part_screen.hpp"

#include "narrow_phase/part_pair.hpp"

namespace plannercheck {
namespace {

// Of the intervals from..to − 1.
unsigned near_between(const SweptBoxes& boxes, const PosedPolytope& set, unsigned near, std::size_t from,
                      std::size_t to, double limit) {
  const unsigned these = near & ((1U << to) - 1) & ~((1U << from) - 1);
  if (these == 0) return 0;
  const FrameBox box = boxes.around(from, to);
  if (parts_are_far({boxes.frame(), box.low, box.high}, set, limit)) return 0;
  if (to - from == 1) return these;
  const std::size_t middle = (from + to + 1) / 2;
  return near_between(boxes, set, near, from, middle, limit) | near_between(boxes, set, near, middle, to, limit);
}

}  // namespace

unsigned PartScreen::near(const CertifiedPair& pair, unsigned near) const {
  if (near == 0 || !filters_.stands_still(pair.b)) return near;
  const std::int32_t set = filters_.body(pair.a).parts ? pair.a : pair.b, mover = set == pair.a ? pair.b : pair.a;
  if (!filters_.stands_still(set)) return near;
  const Polytope& body = filters_.body(mover);
  return near_boxes(mover, set, {body.low, body.high}, near, filters_.apart(pair));
}

unsigned PartScreen::near_group(std::int32_t index, std::uint64_t motion, std::vector<GroupIntervals>& known) const {
  const std::int32_t of_pair = groups_.of_pair[at(index)];
  if (of_pair < 0) return filters_.all_intervals();
  const PartGroup& group = groups_.groups[at(of_pair)];
  if (!filters_.stands_still(group.set)) return filters_.all_intervals();
  GroupIntervals& found = known[at(of_pair)];
  if (found.motion == motion) return found.near;
  double apart = 0;
  for (const std::int32_t member : group.pairs) apart = larger(apart, filters_.apart(model_.pairs[at(member)]));
  found = {motion, near_boxes(group.mover, group.set, {group.low, group.high}, filters_.all_intervals(), apart)};
  return found.near;
}

unsigned PartScreen::near_boxes(std::int32_t mover, std::int32_t set, const FrameBox& box, unsigned near,
                                double apart) const {
  const SweptBoxes boxes(grid_, mover, box, (grid_.intervals() + 1) / 2);
  const PosedPolytope posed{&filters_.body(set), model_.bodies[at(set)].placement};
  return near_between(boxes, posed, near, 0, grid_.intervals(), apart + room_);
}

}  // namespace plannercheck
