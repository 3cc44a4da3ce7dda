// The checker of planar robots in Python: batches with the GIL released, on any number of threads.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "bindings/planar_arrays.hpp"
#include "bindings/workspace_pool.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace planar_binding {  // names of its own: bindings are compiled in one piece

using Rows = InputArray<double, -1, -1>;

class BoundPlanarChecker : public Pooled<PlanarChecker> {
 public:
  BoundPlanarChecker(const PlanarModel& model, bool bounds, Precision first)
      : Pooled(model.links, model.width, model.bodies, model.pairs, bounds, first), polygons_(model.polygons) {}

  nb::dict statistics() {
    using C = PlanarCheckerCounters;
    using P = PlanarCounters;
    const C total = counted();
    nb::dict out = named_counters(total, {{"states", &C::states},
                                          {"pairs", &C::pairs},
                                          {"bounds", &C::bounds},
                                          {"tests", &C::tests},
                                          {"skipped", &C::skipped}});
    out["queries"] = named_counters(total.pair, {{"rounds", &P::rounds},
                                                 {"vertices", &P::vertices},
                                                 {"double_double", &P::double_double},
                                                 {"exact", &P::exact}});
    return out;
  }

 private:
  nb::list polygons_;  // kept alive
};

auto first_of_states(BoundPlanarChecker& checker, Rows q, int threads) {
  const std::size_t width = q.shape(1);
  return checker.of_rows<std::int32_t>(
      q.shape(0), threads, [&](std::size_t row, std::size_t n, std::int32_t* first, PlanarChecker::Workspace& w) {
        checker.core().first_collisions(q.data() + row * width, n, first, w);
      });
}

auto all_of_states(BoundPlanarChecker& checker, Rows q) {
  const std::size_t n = q.shape(0), pairs = checker.core().pair_count();
  std::vector<std::uint8_t> colliding(n * pairs);
  without_gil([&] {
    checker.with_workspace([&](auto& w) { checker.core().all_collisions(q.data(), n, colliding.data(), w); });
  });
  return output_array(colliding, {n, pairs});
}

auto motions_are_free(BoundPlanarChecker& checker, Rows q0, Rows q1, InputArray<std::int64_t, -1> steps) {
  const std::size_t width = q0.shape(1);
  return checker.of_each_row<std::uint8_t>(steps.shape(0), 1, [&](std::size_t i, PlanarChecker::Workspace& w) {
    const double *start = q0.data() + i * width, *end = q1.data() + i * width;
    return checker.core().motion_is_free(start, end, static_cast<long>(steps(i)), w);
  });
}

auto link_poses(const BoundPlanarChecker& checker, Rows q) {
  const std::size_t n = q.shape(0), links = checker.core().link_count();
  std::vector<double> poses(n * links * 9);
  checker.core().link_poses(q.data(), n, poses.data());
  return output_array(poses, {n, links, std::size_t{3}, std::size_t{3}});
}

}  // namespace planar_binding

void bind_planar_checker(nb::module_& m) {
  nb::class_<PlanarModel>(m, "PlanarModel")
      .def(nb::init<InputArray<std::int32_t, -1, 3>, InputArray<double, -1, 3>, std::int32_t, nb::list,
                    InputArray<std::int32_t, -1>, InputArray<double, -1, 3, 3>, InputArray<double, -1, 3>,
                    InputArray<double, -1, 4>, InputArray<std::int32_t, -1, 2>>(),
           plain_floats);
  nb::class_<planar_binding::BoundPlanarChecker>(m, "PlanarChecker")
      .def(nb::init<const PlanarModel&, bool, Precision>(), plain_floats)
      .def("first_of_states", &planar_binding::first_of_states, plain_floats)
      .def("all_of_states", &planar_binding::all_of_states, plain_floats)
      .def("motions_are_free", &planar_binding::motions_are_free, plain_floats)
      .def("link_poses", &planar_binding::link_poses, plain_floats)
      .def("statistics", &planar_binding::BoundPlanarChecker::statistics, plain_floats);
}

}  // namespace plannercheck
