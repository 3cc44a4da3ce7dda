#include "broad_phase/single_state_filter.hpp"

#include <algorithm>
#include <utility>

namespace plannercheck {
namespace {

typedef float Centre __attribute__((vector_size(kDouble4Lanes * 4)));  // x, y, z, and a lane to spare

Centre posed_centre(const BoundingBall& ball, const PoseColumns* links) {
  const Double4* const c = links[at(ball.link)].column;
  const double x = ball.centre[0], y = ball.centre[1], z = ball.centre[2];
  return __builtin_convertvector(((c[0] * x + c[1] * y) + c[2] * z) + c[3], Centre);
}

// Built in registers: a wide load after narrow stores would be a store-forwarding stall.
void set_numbers(const Centre (&centres)[kFloats], SingleStateFilter::Posed& out) {
  const auto both = [&](std::size_t k) { return shuffled<0, 1, 2, 3, 4, 5, 6, 7>(centres[k], centres[k + 4]); };
  const Floats a = both(0), b = both(1), c = both(2), d = both(3);
  const Floats ab = shuffled<0, 8, 1, 9, 4, 12, 5, 13>(a, b), cd = shuffled<0, 8, 1, 9, 4, 12, 5, 13>(c, d);
  out.x = shuffled<0, 1, 8, 9, 4, 5, 12, 13>(ab, cd);
  out.y = shuffled<2, 3, 10, 11, 6, 7, 14, 15>(ab, cd);
  const Floats z_ab = shuffled<2, 10, 3, 11, 6, 14, 7, 15>(a, b), z_cd = shuffled<2, 10, 3, 11, 6, 14, 7, 15>(c, d);
  out.z = shuffled<0, 1, 8, 9, 4, 5, 12, 13>(z_ab, z_cd);
}

using Partner = SingleStateFilter::Partner;

// Eight partners at a time that `kind` says to be alike, and fewer where no more are.
template <class Kind>
std::vector<std::vector<Partner>> by_eights(std::vector<Partner>& partners, Kind kind) {
  std::stable_sort(partners.begin(), partners.end(),
                   [&](const Partner& a, const Partner& b) { return kind(a) < kind(b); });
  std::vector<std::vector<Partner>> out;
  for (const Partner& partner : partners) {
    if (out.empty() || out.back().size() == kFloats || kind(out.back()[0]) != kind(partner)) out.emplace_back();
    out.back().push_back(partner);
  }
  return out;
}

std::array<std::int32_t, kFloats> pairs_of(const std::vector<Partner>& partners) {
  std::array<std::int32_t, kFloats> out{};
  for (std::size_t k = 0; k < partners.size(); ++k) out[k] = partners[k].pair;
  return out;
}

int place_in_eight(std::size_t ball) { return static_cast<int>(ball % kFloats); }

}  // namespace

SingleStateFilter::SingleStateFilter(std::vector<BoundingBall> balls,
                                     const std::vector<std::vector<BoundingBall>>& slices,
                                     const std::vector<Box>& boxes, const std::vector<Partner>& balls_with_balls,
                                     const std::vector<Partner>& balls_with_boxes)
    : balls_(std::move(balls)) {
  std::vector<std::size_t> first_slice;
  for (const auto& of_body : slices) {
    first_slice.push_back(balls_.size());
    balls_.insert(balls_.end(), of_body.begin(), of_body.end());
  }
  add_ball_tests(balls_with_balls, slices, first_slice);
  add_box_tests(balls_with_boxes, boxes);
  while (balls_.size() % kFloats != 0) balls_.push_back(balls_.back());  // whole eights; nobody has a pair with these
  sizes_.resize(eights_of(balls_.size()));
  for (std::size_t b = 0; b < balls_.size(); ++b) {
    sizes_[b / kFloats].radius[b % kFloats] = balls_[b].radius;
    sizes_[b / kFloats].room[b % kFloats] = balls_[b].room;
  }
}

// The first slice of a sliced body takes the place of the whole body's ball.
void SingleStateFilter::add_ball_tests(std::vector<Partner> partners,
                                       const std::vector<std::vector<BoundingBall>>& slices,
                                       const std::vector<std::size_t>& first_slice) {
  const auto first_ball = [&](std::size_t body) { return slices[body].empty() ? body : first_slice[body]; };
  for (Partner& partner : partners) {
    if (slices[partner.ball].empty() && !slices[partner.other].empty()) std::swap(partner.ball, partner.other);
  }
  const auto eights = [&](const Partner& partner) {
    return std::array{first_ball(partner.ball) / kFloats, partner.other / kFloats};
  };
  for (const auto& together : by_eights(partners, eights)) {
    BallTest test{};
    test.balls.eight = eights(together[0])[0], test.others.eight = eights(together[0])[1];
    for (std::size_t k = 0; k < together.size(); ++k) {
      test.balls.places[k] = place_in_eight(first_ball(together[k].ball));
      test.others.places[k] = place_in_eight(together[k].other);
      test.pairs = static_cast<std::uint8_t>(test.pairs | 1U << k);
    }
    add_slice_tests(together, slices, first_slice);
    ball_tests_.push_back(test);
    pairs_.push_back(pairs_of(together));
  }
}

// Adds the other slices of the pairs of the next test of balls. Boxes are tested against whole bodies: slices would
// save less time there than they cost.
void SingleStateFilter::add_slice_tests(const std::vector<Partner>& partners,
                                        const std::vector<std::vector<BoundingBall>>& slices,
                                        const std::vector<std::size_t>& first_slice) {
  std::vector<SliceTest> tests;  // each of slices of one eight
  const auto test_of = [&](std::size_t k, std::size_t eight) -> BallTest& {
    for (SliceTest& some : tests)
      if (some.test.balls.eight == eight && (some.test.pairs >> k & 1U) == 0) return some.test;
    return tests.emplace_back(SliceTest{{{{}, eight}, {{}, partners[0].other / kFloats}, 0}, ball_tests_.size()}).test;
  };
  for (std::size_t k = 0; k < partners.size(); ++k) {
    const auto [body, other, pair] = partners[k];
    for (std::size_t slice = 1; slice < slices[body].size(); ++slice) {
      const std::size_t ball = first_slice[body] + slice;
      BallTest& test = test_of(k, ball / kFloats);
      test.balls.places[k] = place_in_eight(ball), test.others.places[k] = place_in_eight(other);
      test.pairs = static_cast<std::uint8_t>(test.pairs | 1U << k);
    }
  }
  slice_tests_.insert(slice_tests_.end(), tests.begin(), tests.end());
}

void SingleStateFilter::add_box_tests(std::vector<Partner> partners, const std::vector<Box>& boxes) {
  const auto eight = [](const Partner& partner) { return partner.ball / kFloats; };
  for (const auto& together : by_eights(partners, eight)) {
    std::vector<Box> of_partners;
    for (const Partner& partner : together) of_partners.push_back(boxes[partner.other]);
    BoxTest test{{{}, eight(together[0])}, side_by_side<Floats>(of_partners)[0]};
    for (std::size_t k = 0; k < together.size(); ++k) test.balls.places[k] = place_in_eight(together[k].ball);
    box_tests_.push_back(test);
    pairs_.push_back(pairs_of(together));
  }
}

// Poses in doubles, as the links are; the balls' room covers it.
void SingleStateFilter::pose(const PoseColumns* links, Workspace& w) const {
  for (std::size_t k = 0; k < w.posed.size(); ++k) {
    Centre centres[kFloats];
#pragma GCC unroll 8
    for (std::size_t b = 0; b < kFloats; ++b) centres[b] = posed_centre(balls_[k * kFloats + b], links);
    Posed& p = w.posed[k];
    set_numbers(centres, p);
    p.radius = BoundingBall::radius_at(p.x, p.y, p.z, sizes_[k].radius, sizes_[k].room);
    p.limit = far_beyond(p.radius);
  }
}

}  // namespace plannercheck
