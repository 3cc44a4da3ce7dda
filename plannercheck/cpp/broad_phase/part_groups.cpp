#include "broad_phase/part_groups.hpp"

#include <map>
#include <utility>

namespace plannercheck {
namespace {

// Placements are rigid up to 3.6e-6, and their inverse is taken to be transposed.
constexpr double kPlacementError = 1e-5;

// Each body is posed on its own, by a product of its link's pose and its placement, which errs by less than this part
// of both translations.
constexpr double kPosedError = 16 * 0x1p-53;

void take_corners(const GeometryObject& object, const GeometryObject& first, PartGroup& box) {
  const Polytope& body = *object.body;
  for (int c = 0; c < 8; ++c) {
    const Vec3 corner{(c & 1) == 0 ? body.low.x : body.high.x, (c & 2) == 0 ? body.low.y : body.high.y,
                      (c & 4) == 0 ? body.low.z : body.high.z};
    const Vec3 way = object.placement.apply(corner) - first.placement.translation();
    const Vec3 p = first.placement.rotate_back(way);
    const double room = kPlacementError * (norm_1(way) + norm_1(corner)) +
                        kPosedError * (norm_1(object.placement.translation()) + norm_1(first.placement.translation()));
    const Vec3 grown{room, room, room}, low = p - grown, high = p + grown;
    box.low = {smaller(box.low.x, low.x), smaller(box.low.y, low.y), smaller(box.low.z, low.z)};
    box.high = {larger(box.high.x, high.x), larger(box.high.y, high.y), larger(box.high.z, high.z)};
  }
  box.inflation_radius = larger(box.inflation_radius, body.inflation_radius);
}

}  // namespace

double posing_room(const Pose& mover) { return kPosedError * norm_1(mover.translation()); }

PartGroups part_groups(const std::vector<GeometryObject>& bodies,
                       const std::vector<std::array<std::int32_t, 2>>& pairs) {
  // By the link and the set: the pairs, each with its body.
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<std::pair<std::int32_t, std::int32_t>>> found;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    const Sets sets = sets_of(*bodies[at(a)].body, *bodies[at(b)].body);
    if (!sets.is_one()) continue;
    const std::int32_t set = sets.first ? a : b, mover = sets.first ? b : a;
    if (bodies[at(mover)].link < 0) continue;
    found[{bodies[at(mover)].link, set}].emplace_back(static_cast<std::int32_t>(k), mover);
  }
  PartGroups out;
  out.of_pair.assign(pairs.size(), -1);
  for (const auto& [key, members] : found) {
    if (members.size() < 2) continue;
    PartGroup group{members[0].first, members[0].second, key.second, {}, {}, {}};
    const GeometryObject& first = bodies[at(group.mover)];
    group.low = group.high = 0.5 * (first.body->low + first.body->high);
    for (const auto& [pair, mover] : members) {
      take_corners(bodies[at(mover)], first, group);
      group.pairs.push_back(pair);
      out.of_pair[at(pair)] = static_cast<std::int32_t>(out.groups.size());
    }
    out.groups.push_back(std::move(group));
  }
  return out;
}

}  // namespace plannercheck
