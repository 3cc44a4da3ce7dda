// States of OMPL's spaces in Python as lists and arrays of numbers, and how many motions have been judged.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include <cstddef>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/module.hpp"
#include "bindings/ompl_states.hpp"
#include "bindings/plain_floats.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

nb::list numbers_of(const PlannerStates& states, nb::handle state) {
  StateNumbers q(states.width());
  states.read(state, q);
  return listed(q);
}

// (n, width) for a list of n states.
auto rows_of(const PlannerStates& states, nb::list all) {
  std::vector<double> rows;
  StateNumbers q(states.width());
  for (const nb::handle state : all) {
    states.read(state, q);
    rows.insert(rows.end(), q.begin(), q.end());
  }
  return output_array(rows, {rows.size() / states.width(), states.width()});
}

}  // namespace

void bind_ompl_states(nb::module_& m) {
  nb::class_<PlannerStates>(m, "PlannerStates")
      .def(nb::init<std::size_t, nb::object>(), nb::arg("width"), nb::arg("serialize").none(), plain_floats)
      .def("numbers", &numbers_of, plain_floats)
      .def("rows", &rows_of, plain_floats);
  nb::class_<MotionCounts>(m, "MotionCounts")
      .def(nb::init<>(), plain_floats)
      .def("add", &MotionCounts::add, plain_floats)
      .def("reset", &MotionCounts::reset, plain_floats)
      .def_ro("free", &MotionCounts::free, plain_floats)
      .def_ro("refused", &MotionCounts::refused, plain_floats);
}

}  // namespace plannercheck
