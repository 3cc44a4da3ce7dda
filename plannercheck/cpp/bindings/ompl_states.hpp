// States of an OMPL RealVectorStateSpace in Python: `state[k]` is the k-th number. OMPL's Python classes have no
// headers to build against, so this calls them as Python would, without Python's overhead.
#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <cstddef>
#include <vector>

namespace plannercheck {

// The numbers of one state, for one call. Reading a state may run Python, which may switch threads or call again from
// within. So no two calls may share their numbers, though each holds the GIL. Up to kFew stay on the stack.
class StateNumbers {
 public:
  explicit StateNumbers(std::size_t width) : width_(width) {
    if (width > kFew) many_.resize(width);
  }
  StateNumbers(const StateNumbers&) = delete;
  StateNumbers& operator=(const StateNumbers&) = delete;

  double* data() { return width_ > kFew ? many_.data() : few_.data(); }
  const double* data() const { return width_ > kFew ? many_.data() : few_.data(); }
  std::size_t size() const { return width_; }
  const double* begin() const { return data(); }
  const double* end() const { return data() + width_; }

 private:
  // Half a kilobyte; the shipped robot with the most has 44 numbers.
  static constexpr std::size_t kFew = 64;

  std::size_t width_;
  std::array<double, kFew> few_;  // not initialised: `read` writes all that is used
  std::vector<double> many_;
};

class PlannerStates {
 public:
  explicit PlannerStates(std::size_t width) {
    for (std::size_t k = 0; k < width; ++k) columns_.push_back(nanobind::int_(k));
  }

  std::size_t width() const { return columns_.size(); }

  // Writes a state's numbers to q, of this width; throws Python's error for a state that is no such row. Number by
  // number is three times faster than a slice (measured).
  void read(nanobind::handle state, StateNumbers& numbers) const {
    double* const q = numbers.data();
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
inline nanobind::list listed(const StateNumbers& q) {
  nanobind::list out;
  for (const double value : q) out.append(value);
  return out;
}

}  // namespace plannercheck
