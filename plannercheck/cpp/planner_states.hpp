// States of an OMPL RealVectorStateSpace in Python: `state[k]` is the k-th number. OMPL's own classes have no headers
// to build against; this asks them as Python would, and skips all else that Python would do.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <vector>

namespace plannercheck {

class PlannerStates {
 public:
  explicit PlannerStates(std::size_t width) {
    for (std::size_t k = 0; k < width; ++k) columns_.push_back(nanobind::int_(k));
  }

  // Writes a state's numbers to q; throws what Python throws for a state that is no such row. Number by number is three
  // times faster than a slice (measured).
  void read(nanobind::handle state, double* q) const {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const nanobind::object number = nanobind::steal(PyObject_GetItem(state.ptr(), columns_[k].ptr()));
      if (!number.is_valid()) throw nanobind::python_error();
      q[k] = PyFloat_AsDouble(number.ptr());
      if (q[k] == -1 && PyErr_Occurred() != nullptr) throw nanobind::python_error();
    }
  }

 private:
  std::vector<nanobind::object> columns_;
};

// A list of numbers, for functions in Python.
inline nanobind::list listed(const std::vector<double>& q) {
  nanobind::list out;
  for (const double value : q) out.append(value);
  return out;
}

}  // namespace plannercheck
