// Configurations that are no arrays. States of an OMPL RealVectorStateSpace in Python: `state[k]` is the k-th number.
// OMPL's Python classes have no headers to build against, so this calls them as Python would, without Python's
// overhead.
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
    const nanobind::object method = item_method(state);
    const vectorcallfunc call = method.is_none() ? nullptr : PyVectorcall_Function(method.ptr());
    double* const q = numbers.data();
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      PyObject* const arguments[] = {state.ptr(), columns_[k].ptr()};
      const nanobind::object number = nanobind::steal(call == nullptr ? PyObject_GetItem(arguments[0], arguments[1])
                                                                      : call(method.ptr(), arguments, 2, nullptr));
      if (!number.is_valid()) throw nanobind::python_error();
      q[k] = PyFloat_CheckExact(number.ptr()) != 0 ? PyFloat_AS_DOUBLE(number.ptr()) : PyFloat_AsDouble(number.ptr());
      if (q[k] == -1 && PyErr_Occurred() != nullptr) throw nanobind::python_error();
    }
  }

 private:
  std::vector<nanobind::object> columns_;
  // The last state's class and its `__getitem__`. They change under the GIL; a call keeps what it has found.
  mutable nanobind::object type_, method_;

  // What `state[k]` calls with the state and k, or None where only Python knows. Python looks it up for each number,
  // which takes longer than the call.
  nanobind::object item_method(nanobind::handle state) const {
    if (state.type().is(type_)) return method_;
    const nanobind::object type = nanobind::borrow(state.type());
    nanobind::object method = nanobind::getattr(type, "__getitem__", nanobind::none());
    if (PyType_HasFeature(Py_TYPE(method.ptr()), Py_TPFLAGS_METHOD_DESCRIPTOR) == 0) method = nanobind::none();
    type_ = type, method_ = method;
    return method;
  }
};

// Numbers of a list or tuple in place of a state. Only plain ones, whose reading runs no Python.
class ListedNumbers {
 public:
  // False for anything but floats, NumPy's float64 among them, and integers that doubles hold.
  bool read(nanobind::handle row, StateNumbers& numbers) const {
    const bool is_list = PyList_CheckExact(row.ptr()) != 0;
    if (!is_list && PyTuple_CheckExact(row.ptr()) == 0) return false;
    const Py_ssize_t size = is_list ? PyList_GET_SIZE(row.ptr()) : PyTuple_GET_SIZE(row.ptr());
    if (static_cast<std::size_t>(size) != numbers.size()) return false;
    for (Py_ssize_t k = 0; k < size; ++k) {
      PyObject* const item = is_list ? PyList_GET_ITEM(row.ptr(), k) : PyTuple_GET_ITEM(row.ptr(), k);
      if (!read_number(item, numbers.data()[k])) return false;
    }
    return true;
  }

 private:
  nanobind::object numpy_float_ = nanobind::module_::import_("numpy").attr("float64");

  bool read_number(PyObject* item, double& number) const {
    if (PyFloat_CheckExact(item) != 0 || nanobind::handle(item).type().is(numpy_float_)) {
      number = PyFloat_AS_DOUBLE(item);
      return true;
    }
    if (PyLong_CheckExact(item) == 0) return false;
    constexpr long long kExact = 1LL << 53;
    int overflow = 0;
    const long long whole = PyLong_AsLongLongAndOverflow(item, &overflow);
    number = static_cast<double>(whole);
    return overflow == 0 && -kExact <= whole && whole <= kExact;
  }
};

// A list of numbers, for functions in Python.
inline nanobind::list listed(const StateNumbers& q) {
  nanobind::list out;
  for (const double value : q) out.append(value);
  return out;
}

}  // namespace plannercheck
