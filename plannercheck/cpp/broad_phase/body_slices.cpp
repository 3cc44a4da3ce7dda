#include "broad_phase/body_slices.hpp"

#include <algorithm>

namespace plannercheck {
namespace {

// Slices pay if they leave so many pairs fewer a state: posing and testing them takes as long (measured). In blocks,
// where all states share a pair's test, they have to leave out more.
constexpr double kWorthSlicing = 0.25, kWorthSlicingInBlocks = 1;

Vec3 posed_centre(const BoundingBall& ball, const double* link) {
  const double x = ball.centre[0], y = ball.centre[1], z = ball.centre[2];
  const auto along = [&](int i) { return link[i] * x + link[i + 1] * y + link[i + 2] * z + link[i + 3]; };
  return {along(0), along(4), along(8)};
}

bool meet(const BoundingBall& a, const BoundingBall& b, const double* links) {
  const Vec3 way = posed_centre(a, links + 16 * at(a.link)) - posed_centre(b, links + 16 * at(b.link));
  const double radii = static_cast<double>(a.radius) + static_cast<double>(b.radius);
  return dot(way, way) <= radii * radii;
}

// In how many pairs a mover's ball meets one of some others, but no slice does, in all states together.
std::size_t saved(const BoundingBall& whole, const std::vector<BoundingBall>& slices,
                  const std::vector<const BoundingBall*>& others, const SampledPoses& sampled) {
  std::size_t count = 0;
  for (std::size_t state = 0; state < sampled.states; ++state) {
    const double* const links = &sampled.poses[state * (sampled.poses.size() / sampled.states)];
    for (const BoundingBall* other : others) {
      if (!meet(whole, *other, links)) continue;
      count += std::none_of(slices.begin(), slices.end(),
                            [&](const BoundingBall& slice) { return meet(slice, *other, links); })
                   ? 1
                   : 0;
    }
  }
  return count;
}

}  // namespace

std::vector<BodySlices> body_slices(const std::vector<const GeometryObject*>& objects,
                                    const std::vector<BoundingBall>& balls, const std::vector<MovingPair>& pairs,
                                    const SampledPoses& sampled) {
  std::vector<std::vector<const BoundingBall*>> others(objects.size());  // with which each mover has a pair
  for (const MovingPair& pair : pairs) {
    others[at(pair.a)].push_back(&balls[at(pair.b)]);
    others[at(pair.b)].push_back(&balls[at(pair.a)]);
  }
  std::vector<BodySlices> out(objects.size());
  for (std::size_t m = 0; m < objects.size(); ++m) {
    if (sampled.states == 0 || others[m].empty()) continue;
    std::vector<BoundingBall> slices = slice_balls(*objects[m]);
    if (slices.empty()) continue;
    const auto fewer =
        static_cast<double>(saved(balls[m], slices, others[m], sampled)) / static_cast<double>(sampled.states);
    if (fewer > kWorthSlicing) out[m] = {std::move(slices), fewer > kWorthSlicingInBlocks};
  }
  return out;
}

}  // namespace plannercheck
