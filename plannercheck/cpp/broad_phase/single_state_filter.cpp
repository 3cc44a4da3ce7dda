#include "broad_phase/single_state_filter.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace plannercheck {

SingleStateFilter::SingleStateFilter(std::vector<BoundingBall> balls, const std::vector<WorldBox>& boxes,
                                     const std::vector<Partner>& balls_with_balls,
                                     const std::vector<Partner>& balls_with_boxes)
    : balls_(std::move(balls)),
      sizes_(eights_of(balls_.size())),
      boxes_(eights_of(boxes.size())),
      ball_tests_(tests(balls_with_balls, balls_.size(), balls_.size())),
      box_tests_(tests(balls_with_boxes, balls_.size(), boxes.size())) {
  for (std::size_t b = 0; b < balls_.size(); ++b) {
    sizes_[b / kFloats].radius[b % kFloats] = balls_[b].radius;
    sizes_[b / kFloats].room[b % kFloats] = balls_[b].room;
  }
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<int>(i);
      boxes_[b / kFloats].low[i][b % kFloats] = rounded_down(boxes[b].low[axis]);
      boxes_[b / kFloats].high[i][b % kFloats] = rounded_up(boxes[b].high[axis]);
    }
  }
}

// Ball by ball, and by partner.
std::vector<SingleStateFilter::Test> SingleStateFilter::tests(const std::vector<Partner>& partners, std::size_t balls,
                                                              std::size_t others) {
  std::vector<std::vector<Test>> of_ball(balls);
  for (const Partner& partner : partners) {
    auto& own = of_ball[partner.ball];
    for (std::size_t k = own.size(); k < eights_of(others); ++k) own.push_back({partner.ball, k, 0, {}});
    Test& test = own[partner.other / kFloats];
    test.paired = static_cast<std::uint8_t>(test.paired | 1U << partner.other % kFloats);
    test.pairs[partner.other % kFloats] = partner.pair;
  }
  std::vector<Test> out;
  for (const auto& own : of_ball)
    std::copy_if(own.begin(), own.end(), std::back_inserter(out), [](const Test& test) { return test.paired != 0; });
  return out;
}

// Poses in doubles, as the links are; the balls' room covers it.
void SingleStateFilter::pose(const double* links, Workspace& w) const {
  for (std::size_t b = 0; b < balls_.size(); ++b) {
    const double* const m = links + at(balls_[b].link) * 12;
    const double x = balls_[b].centre[0], y = balls_[b].centre[1], z = balls_[b].centre[2];
    const auto row = [&](std::size_t i) {
      return static_cast<float>(((m[i] * x + m[i + 1] * y) + m[i + 2] * z) + m[i + 3]);
    };
    Posed& eight = w.posed[b / kFloats];
    eight.x[b % kFloats] = row(0);
    eight.y[b % kFloats] = row(4);
    eight.z[b % kFloats] = row(8);
  }
  for (std::size_t k = 0; k < w.posed.size(); ++k) {
    Posed& p = w.posed[k];
    p.radius = BoundingBall::radius_at(p.x, p.y, p.z, sizes_[k].radius, sizes_[k].room);
    p.limit = far_beyond(p.radius);
  }
}

}  // namespace plannercheck
