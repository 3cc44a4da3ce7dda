// Tables of distances in Python: sets of configurations, with the GIL released, on any number of threads.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "bindings/workspace_pool.hpp"
#include "distances/distance_core.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using LinkPoses = InputArray<double, -1, -1, 4, 4>;
using Configurations = InputArray<double, -1, -1>;

// Rows that a thread measures at once.
constexpr std::size_t kRowsAtOnce = 256;

class BoundDistances : public Pooled<DistanceCore> {
 public:
  // `paddings`: the part of each body's inflation radius that does not count, m.
  BoundDistances(const std::vector<std::shared_ptr<Polytope>>& bodies, InputArray<double, -1> paddings,
                 InputArray<std::int32_t, -1> links, InputArray<double, -1, 4, 4> placements,
                 InputArray<std::int32_t, -1, 2> pairs, std::int32_t link_count, double limit, const Tuning& tuning,
                 std::shared_ptr<SampledPoses> sampled)
      : Pooled(without_padding(geometry_objects(bodies, links, placements), {paddings.data(), paddings.shape(0)}),
               pairs_from(pairs), link_count, limit, tuning, std::move(sampled)) {}

  // measure(states, table, workspace) for shares of all states; rows in the order of states, then nearest first.
  template <class Measure>
  DistanceTable table(const GivenStates& all, std::size_t width, std::size_t tangent, int threads, Measure measure) {
    const auto takers =
        std::clamp<std::size_t>((all.count + kRowsAtOnce - 1) / kRowsAtOnce, 1, at(std::max(threads, 1)));
    std::vector<DistanceTable> parts(takers);
    std::atomic<std::size_t> taken{0};
    without_gil(takers, [&](std::size_t taker) {
      with_workspace([&](Workspace& w) {
        for (;;) {
          const std::size_t first = taken.fetch_add(kRowsAtOnce);
          if (first >= all.count) break;
          const std::size_t count = std::min(kRowsAtOnce, all.count - first);
          measure(GivenStates{all.kinematics, all.numbers + first * width, first, count, all.earlier}, parts[taker], w);
          poll_interruption();
        }
      });
    });
    return in_order(parts, tangent);
  }
};

// (states, pairs, distances, lower bounds, points, normals, spreads, which are unique, gradients, corners), a row each.
nb::tuple arrays_of(const DistanceTable& table, std::size_t tangent) {
  const std::size_t n = table.rows.size();
  std::vector<std::int64_t> states(n);
  std::vector<std::int32_t> pairs(n), corners(kCornerNumbers * n);
  std::vector<std::uint8_t> unique(n);
  std::vector<double> distances(n), lower(n), points, normals, spreads(n);
  points.reserve(6 * n), normals.reserve(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const DistanceRow& row = table.rows[i];
    states[i] = row.state, pairs[i] = row.pair, distances[i] = row.distance, lower[i] = row.lower;
    append(points, row.on_a), append(points, row.on_b), append(normals, row.normal);
    spreads[i] = row.spread, unique[i] = row.unique;
    std::int32_t* const vertices = &corners[kCornerNumbers * i];
    vertices[0] = row.corners.count;
    std::copy_n(row.corners.body_a.begin(), 4, vertices + 1);
    std::copy_n(row.corners.body_b.begin(), 4, vertices + 5);
  }
  return nb::make_tuple(output_array(states, {n}), output_array(pairs, {n}), output_array(distances, {n}),
                        output_array(lower, {n}), output_array(points, {n, 2, 3}), output_array(normals, {n, 3}),
                        output_array(spreads, {n}), output_array(unique, {n}),
                        output_array(table.gradients, {n, tangent}), output_array(corners, {n, kCornerNumbers}));
}

// `nearest`: how many pairs of each state; 0 for all within the limit.
nb::tuple table_of(BoundDistances& distances, const GivenStates& states, std::size_t width, const Tangent* tangent,
                   int nearest, int rounds, int threads) {
  const std::size_t numbers = tangent == nullptr ? 0 : tangent->width;
  const auto measure = [&](const GivenStates& some, DistanceTable& out, DistanceCore::Workspace& w) {
    if (nearest > 0) {
      distances.core().nearest(some, tangent, at(nearest), rounds, out, w);
    } else {
      distances.core().measure(some, tangent, out, w);
    }
  };
  return arrays_of(distances.table(states, width, numbers, threads, measure), numbers);
}

using Places = InputArray<std::int32_t, -1>;
using Corners = InputArray<std::int32_t, -1, kCornerNumbers>;

EarlierRows earlier_rows(const Places& bounds, const Places& pairs, const Corners& corners, std::size_t states) {
  if (bounds.shape(0) == 0) return {};
  const std::span<const std::int32_t> all{bounds.data(), bounds.shape(0)};
  const bool are_whole = all.size() == states + 1 && all.front() >= 0 && std::is_sorted(all.begin(), all.end()) &&
                         at(all.back()) <= std::min(pairs.shape(0), corners.shape(0));
  if (!are_whole) throw nb::value_error("earlier rows need a bound before each state and one behind");
  return {all, pairs.data(), corners.data()};
}

Tangent tangent_of(const Places& places, const Kinematics& kinematics) {
  if (places.shape(0) != at(kinematics.width())) throw nb::value_error("each number needs its place in the tangent");
  Tangent out;
  out.places.assign(places.data(), places.data() + places.shape(0));
  for (const std::int32_t place : out.places) out.width = std::max(out.width, static_cast<std::size_t>(place + 1));
  return out;
}

nb::tuple of_states(BoundDistances& distances, const Kinematics& kinematics, std::optional<Places> places,
                    Configurations q, int nearest, int rounds, int threads, Places bounds, Places pairs,
                    Corners corners) {
  Tangent tangent;
  if (places) tangent = tangent_of(*places, kinematics);
  const EarlierRows earlier = earlier_rows(bounds, pairs, corners, q.shape(0));
  return table_of(distances, {&kinematics, q.data(), 0, q.shape(0), earlier}, q.shape(1), places ? &tangent : nullptr,
                  nearest, rounds, threads);
}

nb::tuple of_poses(BoundDistances& distances, LinkPoses poses, int nearest, int rounds, int threads) {
  return table_of(distances, {nullptr, poses.data(), 0, poses.shape(0)}, poses.shape(1) * 16, nullptr, nearest, rounds,
                  threads);
}

// (vertices of a, vertices of b, both points, normal, turn) of each place where a pair is nearest at one configuration.
nb::list nearest_places(BoundDistances& distances, const Kinematics& kinematics, InputArray<double, -1> q, int pair) {
  std::vector<NearestPlace> found;
  distances.with_workspace([&](DistanceCore::Workspace& w) {
    found = distances.core().nearest_places({&kinematics, q.data(), 0, 1}, pair, w);
  });
  nb::list out;
  for (const NearestPlace& place : found) {
    const auto points = point_array(std::vector{place.found.on_body_a, place.found.on_body_b});
    out.append(nb::make_tuple(point_array(place.vertices_a), point_array(place.vertices_b), points,
                              point_array(place.found.direction), place.turn));
  }
  return out;
}

// (points, tangent) for points (n, 3) of the first body of a pair, at one configuration.
auto gradients_at(BoundDistances& distances, const Kinematics& kinematics, Places places, InputArray<double, -1> q,
                  int pair, InputArray<double, 3> normal, InputArray<double, -1, 3> points) {
  const Tangent tangent = tangent_of(places, kinematics);
  const std::size_t n = points.shape(0);
  std::vector<double> out;
  distances.with_workspace([&](DistanceCore::Workspace& w) {
    distances.core().gradients_at({&kinematics, q.data(), 0, 1}, tangent, pair, {normal(0), normal(1), normal(2)},
                                  points.data(), n, out, w);
  });
  return output_array(out, {n, tangent.width});
}

}  // namespace

void bind_distance_tables(nb::module_& m) {
  nb::class_<BoundDistances>(m, "Distances")
      .def(nb::init<const std::vector<std::shared_ptr<Polytope>>&, InputArray<double, -1>, InputArray<std::int32_t, -1>,
                    InputArray<double, -1, 4, 4>, InputArray<std::int32_t, -1, 2>, std::int32_t, double, const Tuning&,
                    std::shared_ptr<SampledPoses>>(),
           plain_floats)
      .def("of_states", &of_states, nb::arg("kinematics"), nb::arg("places").none(), nb::arg("q"), nb::arg("nearest"),
           nb::arg("rounds"), nb::arg("threads"), nb::arg("bounds"), nb::arg("pairs"), nb::arg("corners"), plain_floats)
      .def("nearest_places", &nearest_places, plain_floats)
      .def("gradients_at", &gradients_at, plain_floats)
      .def("of_poses", &of_poses, plain_floats);
}

}  // namespace plannercheck
