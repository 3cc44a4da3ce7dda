#include "broad_phase/part_clearances.hpp"

#include <utility>

namespace plannercheck {
namespace {

// A link's pose and a placement are off rigid by at most 3.6e-6 each (plannercheck/robots/unit_lengths.py), so each
// stretches lengths by half of that.
constexpr double kCoverStretch = 1 + 4e-6;

// Bounds the rounding of a centre posed by a placement and then by a link, against a body posed by the product of both:
// dozens of roundings of these numbers. Grids have room for the rounding of the posed centre.
constexpr double kCoverRounding = 0x1p-40;

}  // namespace

PartClearances::PartClearances(std::vector<GeometryObject> bodies, double reach)
    : bodies_(std::move(bodies)), reach_(reach), grids_(bodies_.size()), balls_(bodies_.size()) {}

PartClearances::Look PartClearances::look(std::int32_t a, std::int32_t b) const {
  const Sets sets = sets_of(*bodies_[at(a)].body, *bodies_[at(b)].body);
  const std::int32_t set = sets.first ? a : b, mover = sets.first ? b : a;
  const GeometryObject &parts = bodies_[at(set)], &body = bodies_[at(mover)];
  if (!sets.is_one() || parts.link >= 0 || body.link < 0) return {};
  const ClearanceGrid& found = grid(set);
  if (!found.is_fine()) return {};
  return {&found, &balls_on_link(mover), body.link};
}

const ClearanceGrid& PartClearances::grid(std::int32_t set) const {
  const GeometryObject& object = bodies_[at(set)];
  return grids_[at(set)].get([&] { return ClearanceGrid(object.body->as<PartSet>(), object.placement, reach_); });
}

const std::vector<SmallBall>& PartClearances::balls_on_link(std::int32_t body) const {
  const GeometryObject& object = bodies_[at(body)];
  return balls_[at(body)].get([&] {
    std::vector<SmallBall> balls = object.body->covering_balls();
    for (SmallBall& ball : balls) {
      const double room = (norm_1(ball.centre) + norm_1(object.placement.translation())) * kCoverRounding;
      ball = {object.placement.apply(ball.centre), ball.radius * kCoverStretch + room};
    }
    return balls;
  });
}

bool PartClearances::is_clear(const Look& look, const std::array<double, 12>& link, double margin) {
  const auto& m = link;
  for (const SmallBall& ball : *look.balls) {
    const Vec3& c = ball.centre;
    const Vec3 place{(m[0] * c.x + m[1] * c.y) + (m[2] * c.z + m[3]), (m[4] * c.x + m[5] * c.y) + (m[6] * c.z + m[7]),
                     (m[8] * c.x + m[9] * c.y) + (m[10] * c.z + m[11])};
    if (!(look.grid->from(place) > ball.radius + margin)) return false;
  }
  return true;
}

unsigned PartClearances::clear_lanes(const Look& look, const Lanes* m, double margin) {
  unsigned clear = (1U << kLanes) - 1;
  for (const SmallBall& ball : *look.balls) {
    const Vec3& c = ball.centre;
    const Lanes x = (m[0] * c.x + m[1] * c.y) + (m[2] * c.z + m[3]);
    const Lanes y = (m[4] * c.x + m[5] * c.y) + (m[6] * c.z + m[7]);
    const Lanes z = (m[8] * c.x + m[9] * c.y) + (m[10] * c.z + m[11]);
    clear &= bits(look.grid->from(x, y, z) > broadcast(ball.radius + margin));
    if (clear == 0) break;
  }
  return clear;
}

}  // namespace plannercheck
