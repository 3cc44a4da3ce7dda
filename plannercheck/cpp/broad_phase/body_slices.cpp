#include "broad_phase/body_slices.hpp"

#include <algorithm>

namespace plannercheck {
namespace {

// Slices have to leave so many pairs fewer a single state: posing and testing them takes as long (measured).
constexpr double kWorthSlicing = 0.25;

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

// In how many pairs a mover's ball meets the other one, but no slice does, in all states together.
std::size_t saved(std::int32_t mover, const std::vector<BoundingBall>& slices, const std::vector<BoundingBall>& balls,
                  const std::vector<MovingPair>& pairs, const SampledPoses& sampled) {
  std::size_t count = 0;
  for (std::size_t state = 0; state < sampled.states; ++state) {
    const double* const links = &sampled.poses[state * (sampled.poses.size() / sampled.states)];
    for (const MovingPair& pair : pairs) {
      if (pair.a != mover && pair.b != mover) continue;
      const BoundingBall& other = balls[at(pair.a == mover ? pair.b : pair.a)];
      const bool meets_slice = std::any_of(slices.begin(), slices.end(),
                                           [&](const BoundingBall& slice) { return meet(slice, other, links); });
      count += !meets_slice && meet(balls[at(mover)], other, links) ? 1 : 0;
    }
  }
  return count;
}

}  // namespace

std::vector<BodySlices> body_slices(const std::vector<const GeometryObject*>& objects,
                                    const std::vector<BoundingBall>& balls, const std::vector<MovingPair>& pairs,
                                    const SampledPoses& sampled) {
  std::vector<BodySlices> out(objects.size());
  for (std::size_t m = 0; m < objects.size(); ++m) {
    std::vector<BoundingBall> slices = slice_balls(*objects[m]);
    if (slices.empty() || sampled.states == 0) continue;
    const auto fewer = static_cast<double>(saved(static_cast<std::int32_t>(m), slices, balls, pairs, sampled)) /
                       static_cast<double>(sampled.states);
    if (fewer > kWorthSlicing) out[m] = {std::move(slices), fewer};
  }
  return out;
}

}  // namespace plannercheck
