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

bool PartScreen::is_far(const CertifiedPair& pair) const {
  if (!stands_still(pair)) return false;
  const Polytope& body = filters_.body(mover_of(pair));
  return whole_is_far(mover_of(pair), set_of(pair), {body.low, body.high}, filters_.apart(pair));
}

bool PartScreen::group_is_far(std::int32_t index, std::uint64_t motion, std::vector<MotionGroupLook>& known) const {
  const std::int32_t of_pair = groups_.of_pair[at(index)];
  if (of_pair < 0) return false;
  const PartGroup& group = groups_.groups[at(of_pair)];
  if (!filters_.stands_still(group.set)) return false;
  MotionGroupLook& look = known[at(of_pair)];
  if (look.motion == motion) return look.is_far;
  double apart = 0;
  for (const std::int32_t member : group.pairs) apart = larger(apart, filters_.apart(model_.pairs[at(member)]));
  look = {motion, whole_is_far(group.mover, group.set, {group.low, group.high}, apart)};
  return look.is_far;
}

unsigned PartScreen::near(const CertifiedPair& pair, unsigned near) const {
  if (near == 0 || !stands_still(pair)) return near;
  const std::int32_t mover = mover_of(pair);
  const Polytope& body = filters_.body(mover);
  const SweptBoxes boxes(grid_, mover, {body.low, body.high}, middle());
  return near_between(boxes, posed(set_of(pair)), near, 0, grid_.intervals(), filters_.apart(pair) + room_);
}

bool PartScreen::whole_is_far(std::int32_t mover, std::int32_t set, const FrameBox& box, double apart) const {
  const SweptBoxes boxes(grid_, mover, box, middle());
  const FrameBox all = boxes.around(0, grid_.intervals());
  return parts_are_far({boxes.frame(), all.low, all.high}, posed(set), apart + room_);
}

PosedPolytope PartScreen::posed(std::int32_t set) const {
  return {&filters_.body(set), model_.bodies[at(set)].placement};
}

}  // namespace plannercheck
