// The checker of planar robots in Python: batches with the GIL released, on as many threads as asked for.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <exception>
#include <mutex>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/joined_threads.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "bindings/planar_arrays.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace planar_binding {  // names of its own: bindings are compiled in one piece

using Rows = InputArray<double, -1, -1>;

// The core's checker with the arrays it reads and the sums of its counters.
class BoundPlanarChecker {
 public:
  // links: rows of parent, joint, column; anchors: rows of x, y, angle. circles: rows of x, y, radius of each body;
  // boxes: rows of least x, y, largest x, y.
  BoundPlanarChecker(InputArray<std::int32_t, -1, 3> links, InputArray<double, -1, 3> anchors, std::int32_t width,
                     const nb::list& polygons, InputArray<std::int32_t, -1> mounts, InputArray<double, -1, 3, 3> poses,
                     InputArray<double, -1, 3> circles, InputArray<double, -1, 4> boxes,
                     InputArray<std::int32_t, -1, 2> pairs, bool bounds, Precision first)
      : polygons_(polygons),
        core_(planar_arrays::links_from(links, anchors), width,
              planar_arrays::bodies_from(polygons, mounts, poses, circles, boxes), planar_arrays::pairs_from(pairs),
              bounds, first) {}

  const PlanarChecker& core() const { return core_; }

  void add(const PlanarCheckerCounters& c) {
    const std::lock_guard lock(mutex_);
    total_.states += c.states, total_.pairs += c.pairs, total_.bounds += c.bounds;
    total_.tests += c.tests, total_.skipped += c.skipped;
    total_.pair.rounds += c.pair.rounds, total_.pair.vertices += c.pair.vertices;
    total_.pair.double_double += c.pair.double_double, total_.pair.exact += c.pair.exact;
  }

  nb::dict statistics() {
    const PlanarCheckerCounters total = counted();
    nb::dict out, queries;
    out["states"] = total.states;
    out["pairs"] = total.pairs;
    out["bounds"] = total.bounds;
    out["tests"] = total.tests;
    out["skipped"] = total.skipped;
    queries["rounds"] = total.pair.rounds;
    queries["vertices"] = total.pair.vertices;
    queries["double_double"] = total.pair.double_double;
    queries["exact"] = total.pair.exact;
    out["queries"] = queries;
    return out;
  }

 private:
  nb::list polygons_;  // kept alive
  PlanarChecker core_;
  std::mutex mutex_;
  PlanarCheckerCounters total_;

  // Python's objects are not made under the lock: its garbage collector may run anything meanwhile.
  PlanarCheckerCounters counted() {
    const std::lock_guard lock(mutex_);
    return total_;
  }
};

// work(first, last, counters) over parts of n rows, one a thread.
template <class Work>
void in_parallel(BoundPlanarChecker& checker, std::size_t n, int threads, Work work) {
  const auto count = static_cast<std::size_t>(std::max(threads, 1));
  std::exception_ptr failure;  // an exception that leaves a thread would end the process
  std::mutex mutex;
  const auto part = [&](std::size_t k) {
    try {
      PlanarCheckerCounters counters;
      work(n * k / count, n * (k + 1) / count, counters);
      checker.add(counters);
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
    }
  };
  {
    JoinedThreads others;
    for (std::size_t k = 1; k < count; ++k) others.threads.emplace_back(part, k);
    part(0);
  }
  if (failure) std::rethrow_exception(failure);
}

auto first_of_states(BoundPlanarChecker& checker, Rows q, int threads) {
  std::vector<std::int32_t> first(q.shape(0));
  {
    nb::gil_scoped_release release;
    in_parallel(checker, first.size(), threads, [&](std::size_t from, std::size_t to, PlanarCheckerCounters& counters) {
      checker.core().first_collisions(q.data() + from * q.shape(1), to - from, first.data() + from, counters);
    });
  }
  return output_array(first, {first.size()});
}

auto all_of_states(BoundPlanarChecker& checker, Rows q) {
  const std::size_t n = q.shape(0), pairs = checker.core().pair_count();
  std::vector<std::uint8_t> colliding(n * pairs);
  {
    nb::gil_scoped_release release;
    PlanarCheckerCounters counters;
    checker.core().all_collisions(q.data(), n, colliding.data(), counters);
    checker.add(counters);
  }
  return output_array(colliding, {n, pairs});
}

auto motions_are_free(BoundPlanarChecker& checker, Rows q0, Rows q1, InputArray<std::int64_t, -1> steps) {
  std::vector<std::uint8_t> free(steps.shape(0));
  {
    nb::gil_scoped_release release;
    PlanarCheckerCounters counters;
    for (std::size_t i = 0; i < free.size(); ++i) {
      free[i] = checker.core().motion_is_free(q0.data() + i * q0.shape(1), q1.data() + i * q1.shape(1),
                                              static_cast<long>(steps(i)), counters);
    }
    checker.add(counters);
  }
  return output_array(free, {free.size()});
}

auto link_poses(const BoundPlanarChecker& checker, Rows q) {
  const std::size_t n = q.shape(0), links = checker.core().link_count();
  std::vector<double> poses(n * links * 9);
  checker.core().link_poses(q.data(), n, poses.data());
  return output_array(poses, {n, links, std::size_t{3}, std::size_t{3}});
}

}  // namespace planar_binding

void bind_planar_checker(nb::module_& m) {
  nb::class_<planar_binding::BoundPlanarChecker>(m, "PlanarChecker")
      .def(nb::init<InputArray<std::int32_t, -1, 3>, InputArray<double, -1, 3>, std::int32_t, const nb::list&,
                    InputArray<std::int32_t, -1>, InputArray<double, -1, 3, 3>, InputArray<double, -1, 3>,
                    InputArray<double, -1, 4>, InputArray<std::int32_t, -1, 2>, bool, Precision>(),
           plain_floats)
      .def("first_of_states", &planar_binding::first_of_states, plain_floats)
      .def("all_of_states", &planar_binding::all_of_states, plain_floats)
      .def("motions_are_free", &planar_binding::motions_are_free, plain_floats)
      .def("link_poses", &planar_binding::link_poses, plain_floats)
      .def("statistics", &planar_binding::BoundPlanarChecker::statistics, plain_floats);
}

}  // namespace plannercheck
