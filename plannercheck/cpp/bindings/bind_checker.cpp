// The checker in Python: batches of configurations, with the GIL released, on any number of threads.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
#include "bindings/numpy_row.hpp"
#include "bindings/ompl_states.hpp"
#include "bindings/plain_floats.hpp"
#include "bindings/unit_parts.hpp"
#include "bindings/verdict_dicts.hpp"
#include "bindings/workspace_pool.hpp"
#include "checking/checker.hpp"
#include "checking/joint_limits.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using Configurations = InputArray<double, -1, -1>;
using LinkPoses = InputArray<double, -1, -1, 4, 4>;

using CellsOfPairs = std::vector<std::pair<std::shared_ptr<ApartCells>, InputArray<std::int32_t, -1>>>;  // by bit

constexpr std::size_t kPoseStride = 16;

class BoundChecker : public Pooled<CheckerCore> {
 public:
  BoundChecker(std::vector<std::shared_ptr<Polytope>> bodies, InputArray<std::int32_t, -1> links,
               InputArray<double, -1, 4, 4> placements, InputArray<std::int32_t, -1, 2> pairs, std::int32_t link_count,
               InputArray<double, -1> lower, InputArray<double, -1> upper, const Tuning& tuning,
               std::shared_ptr<SampledPoses> sampled, const CellsOfPairs& in_cells)
      : Pooled(geometry_objects(bodies, links, placements), pairs_from(pairs), link_count, tuning,
               of_links(std::move(sampled), link_count), pairs_in_cells(in_cells, pairs.shape(0))),
        limits_({lower.data(), lower.data() + lower.shape(0)}, {upper.data(), upper.data() + upper.shape(0)}) {}

  // The limits that hold for this checker's choice of pairs: what is within may be judged.
  const JointLimits& limits() const { return limits_; }

  // Judges one configuration that is within these limits.
  bool is_valid(const Kinematics& kinematics, const double* q) {
    std::uint8_t valid = 0;
    with_workspace([&](auto& w) { core().check_states(kinematics, q, 1, &valid, w); });
    return valid != 0;
  }

  nb::dict statistics() {
    using C = CheckerCounters;
    const C total = counted();
    nb::dict out = named_counters(total, {{"states", &C::states},
                                          {"pairs", &C::pairs},
                                          {"bounds", &C::bounds},
                                          {"overlaps", &C::overlaps},
                                          {"boxes", &C::boxes},
                                          {"skipped", &C::skipped},
                                          {"trees", &C::trees}});
    constexpr std::array<const char*, kStages> names{"cached_plane",   "box_face",      "centre_axis", "solver",
                                                     "nearest_points", "double_double", "exact"};
    for (std::size_t i = 0; i < total.stages.size(); ++i) out[names[i]] = total.stages[i];
    out["queries"] = counters_dict(total.pair);
    return out;
  }

 private:
  JointLimits limits_;

  static std::vector<PairsInCells> pairs_in_cells(const CellsOfPairs& given, std::size_t pairs) {
    std::vector<PairsInCells> out;
    for (const auto& [cells, numbers] : given) {
      PairsInCells& own = out.emplace_back();
      own.cells = cells;
      own.pairs.fill(-1);
      for (std::size_t bit = 0; bit < own.pairs.size() && bit < numbers.shape(0); ++bit) {
        own.pairs[bit] = numbers(bit);
        if (numbers(bit) >= static_cast<std::int32_t>(pairs))
          throw std::invalid_argument("pair " + std::to_string(numbers(bit)) + " in cells is none of " +
                                      std::to_string(pairs));
      }
    }
    return out;
  }

  static std::shared_ptr<const SampledPoses> of_links(std::shared_ptr<SampledPoses> poses, std::int32_t link_count) {
    if (poses->poses.size() != poses->states * static_cast<std::size_t>(link_count) * kPoseStride) {
      throw std::invalid_argument("sampled poses are not of all " + std::to_string(link_count) + " links");
    }
    return poses;
  }
};

// Poses of all links in some states: (n, links, 4, 4).
std::shared_ptr<SampledPoses> sampled_poses(LinkPoses poses) {
  return std::make_shared<SampledPoses>(
      SampledPoses{std::vector<double>(poses.data(), poses.data() + poses.size()), poses.shape(0)});
}

auto first_of_states(BoundChecker& checker, const Kinematics& kinematics, Configurations q, int threads) {
  const std::size_t width = q.shape(1);
  return checker.of_rows<std::int32_t>(
      q.shape(0), threads, [&](std::size_t row, std::size_t n, std::int32_t* first, CheckerCore::Workspace& w) {
        checker.core().first_collisions(kinematics, q.data() + row * width, n, first, w);
      });
}

using Columns = InputArray<std::int32_t, -1, 2>;

// A function of one configuration, without the overhead of sets. It returns None for anything but finite numbers within
// the limits, with unit vectors of length 1, in a NumPy row, a list or a tuple; the caller then handles it.
nb::object row_validity(nb::object checker, nb::object kinematics, Columns units, double tolerance) {
  auto* judge = nb::cast<BoundChecker*>(checker);
  const auto* kernel = nb::cast<const Kinematics*>(kinematics);
  const auto width = static_cast<std::size_t>(kernel->width());
  const auto judged = [checker, kinematics, judge, kernel,
                       lengths = UnitParts(units, tolerance)](const double* q) -> nb::object {
    if (!judge->limits().hold(q) || !lengths.are_unit(q)) return nb::none();
    return nb::bool_(judge->is_valid(*kernel, q));
  };
  const auto is_free = [judged, width, array = NumpyArray(), listed = ListedNumbers()](nb::handle row) -> nb::object {
    if (const NumpyRow q(array, row, width); q.data() != nullptr) return judged(q.data());
    StateNumbers numbers(width);
    return listed.read(row, numbers) ? judged(numbers.data()) : nb::none();
  };
  return nb::cpp_function(is_free, plain_floats);
}

// The judge of sets, (n, nq) arrays: returns an array (n,) of whether each configuration is free, or None.
nb::object set_validity(nb::object checker, nb::object kinematics, Columns units, double tolerance) {
  auto* judge = nb::cast<BoundChecker*>(checker);
  const auto* kernel = nb::cast<const Kinematics*>(kinematics);
  const auto width = static_cast<std::size_t>(kernel->width());
  const auto are_free = [checker, kinematics, judge, kernel, width, array = NumpyArray(),
                         lengths = UnitParts(units, tolerance)](nb::handle rows, int threads) -> nb::object {
    const NumpyRows q(array, rows, width);
    if (q.n == 0 || !judge->limits().hold(q.data, q.n) || !lengths.are_unit(q.data, q.n, width)) return nb::none();
    return nb::cast(judge->of_rows<std::uint8_t>(
        q.n, threads, [&](std::size_t row, std::size_t n, std::uint8_t* valid, CheckerCore::Workspace& w) {
          judge->core().check_states(*kernel, q.data + row * width, n, valid, w);
        }));
  };
  return nb::cpp_function(are_free, nb::arg("q").none(), nb::arg("threads"), plain_floats);
}

// A function that OMPL calls with states, read by `states`, as rows if that is null (ompl_states.hpp). It passes states
// beyond the limits to `elsewhere`, which takes a list.
nb::object state_validity(nb::object checker, nb::object kinematics, nb::object elsewhere,
                          std::shared_ptr<const PlannerStates> states, std::shared_ptr<PlannerFailure> failure) {
  auto* judge = nb::cast<BoundChecker*>(checker);
  const auto* kernel = nb::cast<const Kinematics*>(kinematics);
  const auto answer = [checker, kinematics, elsewhere, judge, kernel,
                       states = of_width(at(kernel->width()), std::move(states))](nb::handle s) {
    end_on_signals();
    StateNumbers q(states->width());
    states->read(s, q);
    for (const double value : q) {
      if (!std::isfinite(value)) return false;  // OMPL's spaces hold no such state
    }
    return judge->limits().hold(q.data()) ? judge->is_valid(*kernel, q.data()) : nb::cast<bool>(elsewhere(listed(q)));
  };
  const auto is_free = [answer, failure](nb::handle s) { return judged_or_failed(failure, [&] { return answer(s); }); };
  return nb::cpp_function(is_free, plain_floats);
}

auto check_states(BoundChecker& checker, const Kinematics& kinematics, Configurations q, int threads) {
  const std::size_t width = q.shape(1);
  return checker.of_rows<std::uint8_t>(
      q.shape(0), threads, [&](std::size_t row, std::size_t n, std::uint8_t* valid, CheckerCore::Workspace& w) {
        checker.core().check_states(kinematics, q.data() + row * width, n, valid, w);
      });
}

// q0, q1: n motions; steps: n.
auto motions_are_free(BoundChecker& checker, const Kinematics& kinematics, Configurations q0, Configurations q1,
                      InputArray<std::int64_t, -1> steps) {
  const std::size_t width = q0.shape(1);
  return checker.of_each_row<std::uint8_t>(steps.shape(0), 1, [&](std::size_t i, CheckerCore::Workspace& w) {
    const double *start = q0.data() + i * width, *end = q1.data() + i * width;
    return checker.core().motion_is_free(kinematics, start, end, static_cast<long>(steps(i)), w);
  });
}

auto first_of_poses(BoundChecker& checker, LinkPoses poses, int threads) {
  const std::size_t size = poses.shape(1) * kPoseStride;
  return checker.of_rows<std::int32_t>(
      poses.shape(0), threads, [&](std::size_t row, std::size_t n, std::int32_t* first, CheckerCore::Workspace& w) {
        checker.core().first_collisions(poses.data() + row * size, n, first, w);
      });
}

auto all_of_poses(BoundChecker& checker, LinkPoses poses) {
  const std::size_t n = poses.shape(0), pairs = checker.core().pair_count();
  std::vector<std::uint8_t> colliding(n * pairs);
  without_gil([&] {
    checker.with_workspace([&](auto& w) { checker.core().all_collisions(poses.data(), n, colliding.data(), w); });
  });
  return output_array(colliding, {n, pairs});
}

// Poses of links times placements on them, by the same operations as every verdict.
auto placed_on_links(InputArray<double, -1, 4, 4> links, InputArray<double, -1, 4, 4> placements) {
  const std::size_t n = links.shape(0);
  if (placements.shape(0) != n) {
    throw std::invalid_argument(std::to_string(n) + " link poses with " + std::to_string(placements.shape(0)) +
                                " placements: give each pose one");
  }
  std::vector<double> out(links.data(), links.data() + 16 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const Pose pose = placed_on(pose_from(links.data() + 16 * i).m, pose_from(placements.data() + 16 * i));
    std::copy(pose.m.begin(), pose.m.end(), out.begin() + static_cast<std::ptrdiff_t>(16 * i));
  }
  return output_array(out, {n, std::size_t{4}, std::size_t{4}});
}

auto body_poses(const BoundChecker& checker, LinkPoses poses) {
  const std::size_t n = poses.shape(0), bodies = checker.core().body_count(), size = poses.shape(1) * kPoseStride;
  const double last_row[] = {0, 0, 0, 1};
  std::vector<double> out(n * bodies * 16);
  without_gil([&] {
    for (std::size_t i = 0; i < n; ++i) {
      poll_interruption();
      for (std::size_t b = 0; b < bodies; ++b) {
        const Pose pose = checker.core().body_pose(b, poses.data() + i * size);
        double* to = out.data() + (i * bodies + b) * 16;
        std::copy(pose.m.begin(), pose.m.end(), to);
        std::copy_n(last_row, 4, to + 12);
      }
    }
  });
  return output_array(out, {n, bodies, std::size_t{4}, std::size_t{4}});
}

}  // namespace

std::vector<GeometryObject> geometry_objects(const std::vector<std::shared_ptr<Polytope>>& bodies,
                                             InputArray<std::int32_t, -1> links,
                                             InputArray<double, -1, 4, 4> placements) {
  std::vector<GeometryObject> out;
  for (std::size_t i = 0; i < bodies.size(); ++i) out.push_back({bodies[i], links(i), pose_at(placements, i)});
  return out;
}

std::shared_ptr<const CheckerCore> shared_checker_core(nb::object checker) {
  const CheckerCore* core = &nb::cast<const BoundChecker*>(checker)->core();
  return {core, [checker = std::move(checker)](const CheckerCore*) {}};
}

void bind_checker(nb::module_& m) {
  nb::class_<SampledPoses>(m, "SampledPoses");
  m.def("sampled_poses", &sampled_poses, plain_floats);
  nb::class_<BoundChecker>(m, "Checker")
      .def(nb::init<std::vector<std::shared_ptr<Polytope>>, InputArray<std::int32_t, -1>, InputArray<double, -1, 4, 4>,
                    InputArray<std::int32_t, -1, 2>, std::int32_t, InputArray<double, -1>, InputArray<double, -1>,
                    const Tuning&, std::shared_ptr<SampledPoses>, const CellsOfPairs&>(),
           plain_floats)
      .def("first_of_states", &first_of_states, plain_floats)
      .def("check_states", &check_states, plain_floats)
      .def("motions_are_free", &motions_are_free, plain_floats)
      .def("first_of_poses", &first_of_poses, plain_floats)
      .def("all_of_poses", &all_of_poses, plain_floats)
      .def("body_poses", &body_poses, plain_floats)
      .def("statistics", &BoundChecker::statistics, plain_floats);
  m.def("placed_on_links", &placed_on_links, plain_floats);
  m.def("row_validity", &row_validity, nb::arg("checker"), nb::arg("kinematics"), nb::arg("units"),
        nb::arg("tolerance"), plain_floats);
  m.def("set_validity", &set_validity, nb::arg("checker"), nb::arg("kinematics"), nb::arg("units"),
        nb::arg("tolerance"), plain_floats);
  m.def("state_validity", &state_validity, nb::arg("checker"), nb::arg("kinematics"), nb::arg("elsewhere"),
        nb::arg("states").none() = nb::none(), nb::arg("failure").none() = nb::none(), plain_floats);
}

}  // namespace plannercheck
