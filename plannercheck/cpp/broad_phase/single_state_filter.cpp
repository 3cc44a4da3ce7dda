#include "broad_phase/single_state_filter.hpp"

#include <utility>

namespace plannercheck {
namespace {

typedef float Centre __attribute__((vector_size(kDouble4Lanes * 4)));  // x, y, z, and a lane to spare

Centre posed_centre(const BoundingBall& ball, const PoseColumns* links) {
  const Double4* const c = links[at(ball.link)].column;
  const double x = ball.centre[0], y = ball.centre[1], z = ball.centre[2];
  return __builtin_convertvector(((c[0] * x + c[1] * y) + c[2] * z) + c[3], Centre);
}

// Put together in registers: a wide load after narrow stores would wait for them.
void set_side_by_side(const Centre (&centres)[kFloats], SingleStateFilter::Posed& out) {
  const auto both = [&](std::size_t k) { return shuffled<0, 1, 2, 3, 4, 5, 6, 7>(centres[k], centres[k + 4]); };
  const Floats a = both(0), b = both(1), c = both(2), d = both(3);
  const Floats ab = shuffled<0, 8, 1, 9, 4, 12, 5, 13>(a, b), cd = shuffled<0, 8, 1, 9, 4, 12, 5, 13>(c, d);
  out.x = shuffled<0, 1, 8, 9, 4, 5, 12, 13>(ab, cd);
  out.y = shuffled<2, 3, 10, 11, 6, 7, 14, 15>(ab, cd);
  const Floats z_ab = shuffled<2, 10, 3, 11, 6, 14, 7, 15>(a, b), z_cd = shuffled<2, 10, 3, 11, 6, 14, 7, 15>(c, d);
  out.z = shuffled<0, 1, 8, 9, 4, 5, 12, 13>(z_ab, z_cd);
}

}  // namespace

SingleStateFilter::SingleStateFilter(std::vector<BoundingBall> balls,
                                     const std::vector<std::vector<BoundingBall>>& slices,
                                     const std::vector<WorldBox>& boxes, const std::vector<Partner>& balls_with_balls,
                                     const std::vector<Partner>& balls_with_boxes)
    : balls_(std::move(balls)), boxes_(side_by_side(boxes)) {
  const std::size_t count = balls_.size();
  std::vector<Partner> partners = balls_with_balls;
  for (Partner& partner : partners) {
    if (slices[partner.ball].empty() && !slices[partner.other].empty()) std::swap(partner.ball, partner.other);
  }
  ball_tests_ = tests<Posed>(partners, count, count);
  box_tests_ = tests<EightBoxes>(balls_with_boxes, count, boxes.size());
  slice(slices);
  while (balls_.size() % kFloats != 0) balls_.push_back(balls_.back());  // whole eights; nobody has a pair with these
  sizes_.resize(eights_of(balls_.size()));
  for (std::size_t b = 0; b < balls_.size(); ++b) {
    sizes_[b / kFloats].radius[b % kFloats] = balls_[b].radius;
    sizes_[b / kFloats].room[b % kFloats] = balls_[b].room;
  }
}

// Ball by ball, and by partner. `Eight`: of partners.
template <class Eight>
SingleStateFilter::Tests SingleStateFilter::tests(const std::vector<Partner>& partners, std::size_t balls,
                                                  std::size_t others) {
  const std::size_t eights = eights_of(others);
  std::vector<Tests> of_ball(balls);
  for (const Partner& partner : partners) {
    auto& [own, pairs] = of_ball[partner.ball];
    for (std::size_t k = own.size(); k < eights; ++k) {
      own.push_back({place_of<Posed>(partner.ball), place_of<Eight>(k * kFloats), 0});
      pairs.push_back({});
    }
    Test& test = own[partner.other / kFloats];
    test.paired = static_cast<std::uint8_t>(test.paired | 1U << partner.other % kFloats);
    pairs[partner.other / kFloats][partner.other % kFloats] = partner.pair;
  }
  Tests out;
  for (const auto& [own, pairs] : of_ball) {
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (own[k].paired == 0) continue;
      out.tests.push_back(own[k]), out.pairs.push_back(pairs[k]);
    }
  }
  return out;
}

// Puts slices in the place of whole bodies in tests of balls. Boxes are tested against whole bodies: slices would save
// less there than they take.
void SingleStateFilter::slice(const std::vector<std::vector<BoundingBall>>& slices) {
  std::vector<std::size_t> first(slices.size());
  for (std::size_t body = 0; body < slices.size(); ++body) {
    first[body] = balls_.size();
    balls_.insert(balls_.end(), slices[body].begin(), slices[body].end());
  }
  for (std::size_t body = 0; body < slices.size(); ++body) {
    if (slices[body].empty()) continue;
    for (std::size_t slot = 0; slot < ball_tests_.tests.size(); ++slot) {
      Test& test = ball_tests_.tests[slot];
      if (test.own != place_of<Posed>(body)) continue;
      test.own = place_of<Posed>(first[body]);
      for (std::size_t k = 1; k < slices[body].size(); ++k) {
        const Test other{place_of<Posed>(first[body] + k), test.eight, test.paired};
        slice_tests_.push_back({other, static_cast<std::uint32_t>(slot)});
      }
    }
  }
}

// Poses in doubles, as the links are; the balls' room covers it.
void SingleStateFilter::pose(const PoseColumns* links, Workspace& w) const {
  for (std::size_t k = 0; k < w.posed.size(); ++k) {
    Centre centres[kFloats];
#pragma GCC unroll 8
    for (std::size_t b = 0; b < kFloats; ++b) centres[b] = posed_centre(balls_[k * kFloats + b], links);
    Posed& p = w.posed[k];
    set_side_by_side(centres, p);
    p.radius = BoundingBall::radius_at(p.x, p.y, p.z, sizes_[k].radius, sizes_[k].room);
    p.limit = far_beyond(p.radius);
  }
}

}  // namespace plannercheck
