// Distances and clearances in Python, with the GIL released.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <numeric>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "narrow_phase/distance.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

void put_row(std::vector<double>& rows, std::size_t i, Vec3 v) {
  rows[3 * i] = v.x, rows[3 * i + 1] = v.y, rows[3 * i + 2] = v.z;
}

// (overlap, distance, lower bound, points on a, points on b, directions from b to a) for n pairs of poses of the same
// two bodies.
nb::tuple distance_batch(const Polytope& a, PoseRows poses_a, const Polytope& b, PoseRows poses_b) {
  const std::size_t n = std::max(poses_a.shape(0), poses_b.shape(0)), axes = 3;
  std::vector<std::uint8_t> overlap(n);
  std::vector<double> distance(n), lower(n), on_a(axes * n), on_b(axes * n), directions(axes * n);
  without_gil([&] {
    PairCounters counters;
    for (std::size_t i = 0; i < n; ++i) {
      poll_interruption();
      const PairDistance found =
          pair_distance({&a, pose_at(poses_a, i)}, {&b, pose_at(poses_b, i)}, kNoLimit, counters);
      overlap[i] = found.overlap, distance[i] = found.upper, lower[i] = found.lower;
      put_row(on_a, i, found.on_body_a), put_row(on_b, i, found.on_body_b), put_row(directions, i, found.direction);
    }
  });
  return nb::make_tuple(output_array(overlap, {n}), output_array(distance, {n}), output_array(lower, {n}),
                        output_array(on_a, {n, axes}), output_array(on_b, {n, axes}),
                        output_array(directions, {n, axes}));
}

// The least distance among pairs of bodies; pairs whose balls are nearest come first.
struct Clearance {
  double distance = kNoLimit;
  std::int32_t pair = -1;
};

class ClearanceSearch {
 public:
  ClearanceSearch(const std::vector<std::shared_ptr<Polytope>>& bodies, InputArray<std::int32_t, -1, 2> pairs,
                  InputArray<double, -1> paddings)
      : bodies_(bodies), pairs_(pairs), paddings_(paddings), bounds_(pairs.shape(0)), order_(pairs.shape(0)) {}

  // `rounds`: 0 for distances, else the descent's steps for a bound. `poses`: row-major 4x4, one for each body.
  Clearance run(const double* poses, int rounds) {
    for (std::size_t k = 0; k < bounds_.size(); ++k)
      bounds_[k] = ball_gap(body_a(k, poses), body_b(k, poses)) + padding(k);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return bounds_[a] < bounds_[b]; });
    Clearance least;
    for (const std::size_t k : order_) {
      if (bounds_[k] >= least.distance) break;
      const double limit = least.distance - padding(k);
      const double found = rounds > 0 ? distance_bound(body_a(k, poses), body_b(k, poses), rounds, counters_)
                                      : distance_below(body_a(k, poses), body_b(k, poses), limit);
      if (found < limit) least = {found + padding(k), static_cast<std::int32_t>(k)};
    }
    return least;
  }

 private:
  const std::vector<std::shared_ptr<Polytope>>& bodies_;
  InputArray<std::int32_t, -1, 2> pairs_;
  InputArray<double, -1> paddings_;  // per body: the part of its inflation radius that is left out
  std::vector<double> bounds_;
  std::vector<std::size_t> order_;
  PairCounters counters_;

  PosedPolytope posed(std::int32_t body, const double* poses) const {
    return {bodies_[at(body)].get(), pose_from(poses + 16 * at(body))};
  }
  PosedPolytope body_a(std::size_t k, const double* poses) const { return posed(pairs_(k, 0), poses); }
  PosedPolytope body_b(std::size_t k, const double* poses) const { return posed(pairs_(k, 1), poses); }
  double padding(std::size_t k) const { return paddings_(at(pairs_(k, 0))) + paddings_(at(pairs_(k, 1))); }

  // The distance if it is below the limit, else some number that is at least the limit. Of bodies that overlap, minus a
  // depth that surely separates them.
  double distance_below(const PosedPolytope& a, const PosedPolytope& b, double limit) {
    const PairDistance found = pair_distance(a, b, limit, counters_);
    return found.overlap || found.lower > limit ? found.lower : found.upper;
  }
};

// (least distances (n,), rows of their pairs (n,)) for poses (n, bodies, 4, 4).
nb::tuple clearances(const std::vector<std::shared_ptr<Polytope>>& bodies, InputArray<double, -1, -1, 4, 4> poses,
                     InputArray<std::int32_t, -1, 2> pairs, InputArray<double, -1> paddings, int rounds) {
  const std::size_t n = poses.shape(0);
  std::vector<double> distances;
  std::vector<std::int32_t> nearest;
  without_gil([&] {
    ClearanceSearch search(bodies, pairs, paddings);
    for (std::size_t i = 0; i < n; ++i) {
      poll_interruption();
      const Clearance found = search.run(poses.data() + i * bodies.size() * 16, rounds);
      distances.push_back(found.distance), nearest.push_back(found.pair);
    }
  });
  return nb::make_tuple(output_array(distances, {n}), output_array(nearest, {n}));
}

// (n,) lower bounds of the distance of hulls, after some steps: cheap where bodies overlap, too.
auto distance_bounds(const Polytope& a, PoseRows poses_a, const Polytope& b, PoseRows poses_b, int rounds) {
  const std::size_t n = std::max(poses_a.shape(0), poses_b.shape(0));
  std::vector<double> lower(n);
  without_gil([&] {
    PairCounters counters;
    for (std::size_t i = 0; i < n; ++i) {
      poll_interruption();
      lower[i] = distance_bound({&a, pose_at(poses_a, i)}, {&b, pose_at(poses_b, i)}, rounds, counters);
    }
  });
  return output_array(lower, {n});
}

}  // namespace

void bind_distance(nb::module_& m) {
  m.def("distance_bounds", &distance_bounds, plain_floats);
  m.def("distance_batch", &distance_batch, plain_floats);
  m.def("clearances", &clearances, plain_floats);
}

}  // namespace plannercheck
