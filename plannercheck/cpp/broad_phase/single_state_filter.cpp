#include "broad_phase/single_state_filter.hpp"

#include <utility>

namespace plannercheck {

SingleStateFilter::SingleStateFilter(std::vector<BoundingBall> balls, std::size_t links,
                                     const std::vector<WorldBox>& boxes, const std::vector<Partner>& balls_with_balls,
                                     const std::vector<Partner>& balls_with_boxes)
    : balls_(std::move(balls)),
      links_(links),
      sizes_(eights_of(balls_.size())),
      boxes_(eights_of(boxes.size())),
      ball_rows_(rows(balls_with_balls, balls_.size(), balls_.size())),
      box_rows_(rows(balls_with_boxes, balls_.size(), boxes.size())) {
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

std::vector<SingleStateFilter::Row> SingleStateFilter::rows(const std::vector<Partner>& partners, std::size_t balls,
                                                            std::size_t others) {
  std::vector<std::vector<unsigned>> paired(balls, std::vector<unsigned>(eights_of(others)));
  std::vector<std::vector<std::int32_t>> pairs(balls);
  for (const auto& [ball, other, pair] : partners) {
    paired[at(ball)][at(other) / kFloats] |= 1U << at(other) % kFloats;
    pairs[at(ball)].resize(others, -1);
    pairs[at(ball)][at(other)] = pair;
  }
  std::vector<Row> out;
  for (std::size_t b = 0; b < balls; ++b) {
    if (pairs[b].empty()) continue;
    Row row{b, {}, std::move(pairs[b])};
    for (std::size_t k = 0; k < paired[b].size(); ++k) {
      if (paired[b][k] != 0) row.eights.push_back({k, paired[b][k]});
    }
    out.push_back(std::move(row));
  }
  return out;
}

// Poses in doubles, as the links are; the balls' room covers it.
void SingleStateFilter::pose(const Lanes* links, std::size_t state, Workspace& posed) const {
  const Lanes* const group = links + pose_index(links_, state / kLanes, 0);
  const std::size_t lane = state % kLanes;
  for (std::size_t b = 0; b < balls_.size(); ++b) {
    const Lanes* const m = group + at(balls_[b].link) * 12;
    const double x = balls_[b].centre[0], y = balls_[b].centre[1], z = balls_[b].centre[2];
    const auto row = [&](std::size_t i) {
      return static_cast<float>(((m[i][lane] * x + m[i + 1][lane] * y) + m[i + 2][lane] * z) + m[i + 3][lane]);
    };
    Posed& eight = posed[b / kFloats];
    eight.x[b % kFloats] = row(0);
    eight.y[b % kFloats] = row(4);
    eight.z[b % kFloats] = row(8);
  }
  for (std::size_t k = 0; k < posed.size(); ++k) {
    Posed& p = posed[k];
    p.radius = BoundingBall::radius_at(p.x, p.y, p.z, sizes_[k].radius, sizes_[k].room);
  }
}

SingleStateFilter::Ball SingleStateFilter::ball(std::size_t index, const Workspace& posed) {
  const Posed& eight = posed[index / kFloats];
  const std::size_t lane = index % kFloats;
  return {eight.x[lane], eight.y[lane], eight.z[lane], eight.radius[lane]};
}

}  // namespace plannercheck
