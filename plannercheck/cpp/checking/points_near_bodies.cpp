#include "checking/points_near_bodies.hpp"

#include <algorithm>
#include <array>

#include "math/box.hpp"
#include "math/interruption.hpp"
#include "narrow_phase/distance.hpp"
#include "narrow_phase/movable_ball.hpp"
#include "narrow_phase/solid_pair.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kRun = kMostPoints, kRuns = kMostPoints, kBlock = kRuns * kRun;

// The half diagonal of a box, its middle rounded: products, sums, a root and the sum with a radius, some ten roundings.
constexpr double kBodyRunRounding = 1 + 32 * 0x1p-53;

// Up to 64 points by columns, and balls around each run of eight of them, which hold the balls around these points.
class PointBlock {
 public:
  PointBlock(const GivenPoints& points, std::size_t first)
      : count_(std::min(kBlock, points.count - first)), runs_((count_ + kRun - 1) / kRun) {
    for (std::size_t i = 0; i < count_; ++i) {
      const double* const row = points.xyz + 3 * (first + i);
      x_[i] = row[0], y_[i] = row[1], z_[i] = row[2], radius_[i] = points.radii[(first + i) * points.radius_step];
    }
    for (std::size_t r = 0; r < runs_; ++r) enclose(r);
  }

  std::size_t runs() const { return runs_; }
  int count(std::size_t run) const { return static_cast<int>(std::min(kRun, count_ - start(run))); }

  // Bits of the runs that may be near a body.
  unsigned near_runs(const PointsNearHull& body) const {
    return body.maybe_near(middle_x_.data(), middle_y_.data(), middle_z_.data(), run_radius_.data(),
                           static_cast<int>(runs_));
  }
  // Bits of a run's points that are near a body's hull.
  unsigned near(PointsNearHull& body, std::size_t run, PairCounters& counters) const {
    const std::size_t i = start(run);
    return body.near(&x_[i], &y_[i], &z_[i], &radius_[i], count(run), counters);
  }

  Vec3 point(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
  double radius(std::size_t i) const { return radius_[i]; }
  static std::size_t start(std::size_t run) { return run * kRun; }

 private:
  std::size_t count_, runs_;
  std::array<double, kBlock> x_, y_, z_, radius_;
  std::array<double, kRuns> middle_x_, middle_y_, middle_z_, run_radius_;

  void enclose(std::size_t run) {
    const std::size_t first = start(run), past = first + static_cast<std::size_t>(count(run));
    Box box;
    double most = radius_[first];
    for (std::size_t i = first; i < past; ++i) box.add(point(i)), most = larger(most, radius_[i]);
    // Halves first: sums of large numbers overflow.
    const Vec3 middle = 0.5 * box.low + 0.5 * box.high;
    const Vec3 half = larger(box.high - middle, middle - box.low);
    middle_x_[run] = middle.x, middle_y_[run] = middle.y, middle_z_[run] = middle.z;
    run_radius_[run] = (norm_above(half) + most) * kBodyRunRounding;
  }
};

std::vector<PointsNearHull> tests_of(const std::vector<PosedPolytope>& bodies) {
  std::vector<PointsNearHull> tests;
  tests.reserve(bodies.size());
  for (const PosedPolytope& body : bodies) tests.emplace_back(body, Pose{});
  return tests;
}

// Among the points near a solid's hull, the points near the solid itself.
unsigned near_solid(const PosedPolytope& solid, const PointBlock& block, std::size_t run, unsigned near_hull,
                    PairCounters& counters) {
  unsigned near = 0;
  for (; near_hull != 0; near_hull &= near_hull - 1) {
    const auto k = static_cast<std::size_t>(__builtin_ctz(near_hull));
    const std::size_t i = PointBlock::start(run) + k;
    const PosedPolytope ball{&ball_with_surface_at(block.point(i), block.radius(i)), Pose{}};
    if (triangles_contact(ball, solid, {}, counters)) near |= 1U << k;
  }
  return near;
}

// Bits of a run's points that are near a body: all of them if there is no limit.
unsigned near_body(const PosedPolytope& body, PointsNearHull& test, const PointBlock& block, std::size_t run,
                   PairCounters& counters) {
  if (std::isinf(block.radius(PointBlock::start(run)))) return (1U << block.count(run)) - 1;
  const unsigned near_hull = block.near(test, run, counters);
  return body.body->traits().fills_hull() ? near_hull : near_solid(body, block, run, near_hull, counters);
}

// Lowers the bounds of a point's distance from a group to those of one of its bodies.
void take_distance(const PosedPolytope& body, Vec3 point, double& upper, double& lower, PairCounters& counters) {
  if (upper == 0) return;
  const bool is_hull = body.body->traits().fills_hull();
  const PosedPolytope body_a{is_hull ? &ball_at(point, 0) : &ball_with_surface_at(point, 0), Pose{}};
  const PairDistance found = pair_distance(body_a, body, upper, counters);
  upper = found.overlap ? 0 : smaller(upper, found.upper);
  lower = found.overlap ? 0 : smaller(lower, found.lower);
}

}  // namespace

void points_near_bodies(const std::vector<PosedPolytope>& bodies, const GivenPoints& points, std::uint8_t* near) {
  std::vector<PointsNearHull> tests = tests_of(bodies);
  PairCounters counters;
  for (std::size_t first = 0; first < points.count; first += kBlock) {
    poll_interruption();
    const PointBlock block(points, first);
    std::array<unsigned, kRuns> found{};
    for (std::size_t b = 0; b < tests.size(); ++b) {
      for (unsigned left = block.near_runs(tests[b]); left != 0; left &= left - 1) {
        const auto run = static_cast<std::size_t>(__builtin_ctz(left));
        if (found[run] == (1U << block.count(run)) - 1) continue;
        found[run] |= near_body(bodies[b], tests[b], block, run, counters);
      }
    }
    for (std::size_t run = 0; run < block.runs(); ++run) {
      for (int k = 0; k < block.count(run); ++k)
        near[first + PointBlock::start(run) + static_cast<std::size_t>(k)] = found[run] >> k & 1U;
    }
  }
}

PointDistances distances_of_points(const std::vector<PosedPolytope>& bodies, const std::vector<std::int32_t>& group,
                                   std::size_t groups, const GivenPoints& points) {
  const std::size_t size = points.count * groups;
  PointDistances out{std::vector<double>(size, kNoLimit), std::vector<double>(size, kNoLimit)};
  std::vector<PointsNearHull> tests = tests_of(bodies);
  PairCounters counters;
  for (std::size_t first = 0; first < points.count; first += kBlock) {
    const PointBlock block(points, first);
    for (std::size_t b = 0; b < tests.size(); ++b) {
      poll_interruption();
      for (unsigned left = block.near_runs(tests[b]); left != 0; left &= left - 1) {
        const auto run = static_cast<std::size_t>(__builtin_ctz(left));
        unsigned near = near_body(bodies[b], tests[b], block, run, counters);
        for (; near != 0; near &= near - 1) {
          const std::size_t i = PointBlock::start(run) + static_cast<std::size_t>(__builtin_ctz(near));
          const std::size_t place = (first + i) * groups + at(group[b]);
          take_distance(bodies[b], block.point(i), out.upper[place], out.lower[place], counters);
        }
      }
    }
  }
  return out;
}

}  // namespace plannercheck
