// States of OMPL's spaces in Python as lists and arrays of numbers, and how many motions have been judged.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>

#include <cstddef>
#include <cstdint>
#include <memory>
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

// A judge in Python as a planner may call it: its exceptions are kept (PlannerFailure). A `try` in Python would not do,
// since Python raises what signals bring also where a function begins, before its first line.
nb::object remembered_failures(nb::object judge, std::shared_ptr<PlannerFailure> failure) {
  const auto judged = [judge, failure](nb::args states) {
    return judged_or_failed(failure, [&] { return nb::cast<bool>(judge(*states)); });
  };
  return nb::cpp_function(judged, plain_floats);
}

// True from its call after so many on. A planner asks its condition once an iteration.
nb::object call_limit(std::int64_t calls) {
  return nb::cpp_function([left = std::make_shared<std::int64_t>(calls)] { return --*left < 0; }, plain_floats);
}

}  // namespace

void bind_ompl_states(nb::module_& m) {
  nb::class_<PlannerStates>(m, "PlannerStates")
      .def(nb::init<std::size_t, nb::object>(), nb::arg("width"), nb::arg("serialize").none(), plain_floats)
      .def("numbers", &numbers_of, plain_floats)
      .def("rows", &rows_of, plain_floats);
  nb::class_<PlannerFailure>(m, "PlannerFailure")
      .def(nb::init<>(), plain_floats)
      .def("arm", &PlannerFailure::arm, plain_floats)
      .def("disarm", &PlannerFailure::disarm, plain_floats)
      .def("keep", &PlannerFailure::keep, plain_floats)
      .def(
          "remember", [](PlannerFailure& self) { self.remembering.begin(); }, plain_floats)
      .def("forget", [](PlannerFailure& self) { self.remembering.end(); }, plain_floats);
  m.def("remembered_failures", &remembered_failures, plain_floats);
  m.def("call_limit", &call_limit, plain_floats);
  nb::class_<MotionCounts>(m, "MotionCounts")
      .def(nb::init<>(), plain_floats)
      .def("add", &MotionCounts::add, plain_floats)
      .def("reset", &MotionCounts::reset, plain_floats)
      .def_ro("free", &MotionCounts::free, plain_floats)
      .def_ro("refused", &MotionCounts::refused, plain_floats);
}

}  // namespace plannercheck
