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

bool PartScreen::group_is_far(std::int32_t index, std::uint64_t motion, std::vector<MotionGroupLook>& known) const {
  const std::int32_t of_pair = groups_.of_pair[at(index)];
  if (of_pair < 0) return false;
  const PartGroup& group = groups_.groups[at(of_pair)];
  if (!filters_.stands_still(group.set)) return false;
  MotionGroupLook& look = known[at(of_pair)];
  if (look.motion == motion) return look.is_far;
  double apart = 0;
  for (const std::int32_t member : group.pairs) apart = larger(apart, filters_.apart(model_.pairs[at(member)]));
  const SweptBoxes boxes(grid_, group.mover, {group.low, group.high}, middle());
  const FrameBox whole = boxes.around(0, grid_.intervals());
  look = {motion, parts_are_far({boxes.frame(), whole.low, whole.high}, posed(group.set), apart + room_)};
  return look.is_far;
}

unsigned PartScreen::near(const CertifiedPair& pair, unsigned near) const {
  if (near == 0 || !filters_.stands_still(pair.b)) return near;
  const bool first = sets_of(filters_.body(pair.a), filters_.body(pair.b)).first;
  const std::int32_t set = first ? pair.a : pair.b, mover = first ? pair.b : pair.a;
  if (!filters_.stands_still(set)) return near;
  const Polytope& body = filters_.body(mover);
  const SweptBoxes boxes(grid_, mover, {body.low, body.high}, middle());
  return near_between(boxes, posed(set), near, 0, grid_.intervals(), filters_.apart(pair) + room_);
}

PosedPolytope PartScreen::posed(std::int32_t set) const {
  return {&filters_.body(set), model_.bodies[at(set)].placement};
}

}  // namespace plannercheck
