// States of OMPL's spaces in Python, as rows of numbers. OMPL's Python classes have no headers to build against, so
// this calls them as Python would, without Python's overhead.
//
// In: a state, and the space's `serialize`, which copies all numbers of a state at once: bounded joints, angles, and
// compounds of them, part by part. Out: the numbers. Without `serialize`, `state[k]` is the k-th number, as in a
// RealVectorStateSpace: so states of a program's own classes can be read.
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
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
  // `serialize(place, state)` of a space whose states are so many doubles, or None.
  PlannerStates(std::size_t width, nanobind::object serialize) : width_(width), serialize_(std::move(serialize)) {
    if (!serialize_.is_none()) return;
    for (std::size_t k = 0; k < width; ++k) columns_.push_back(nanobind::int_(k));
  }

  std::size_t width() const { return width_; }

  // Writes a state's numbers to q, of this width; throws Python's error for what is no such state.
  void read(nanobind::handle state, StateNumbers& q) const {
    if (columns_.size() == width_) {
      read_items(state, q.data());
    } else {
      read_at_once(state, q.data());
    }
  }

 private:
  // The name that nanobind gives capsules that stand for a `void*`.
  static constexpr const char* kCapsuleName = "nb_handle";

  std::size_t width_;
  nanobind::object serialize_;
  std::vector<nanobind::object> columns_;
  mutable nanobind::object place_;  // of the last call; none while a call has it

  // Number by number is three times faster than a slice (measured).
  void read_items(nanobind::handle state, double* q) const {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const nanobind::object number = nanobind::steal(PyObject_GetItem(state.ptr(), columns_[k].ptr()));
      if (!number.is_valid()) throw nanobind::python_error();
      q[k] = PyFloat_AsDouble(number.ptr());
      if (q[k] == -1 && PyErr_Occurred() != nullptr) throw nanobind::python_error();
    }
  }

  // A call from within, which finds the capsule gone, makes one of its own: none ever changes another one's pointer.
  void read_at_once(nanobind::handle state, double* q) const {
    nanobind::object place = std::exchange(place_, nanobind::object());
    if (!place.is_valid()) {
      place = nanobind::steal(PyCapsule_New(q, kCapsuleName, nullptr));
      if (!place.is_valid()) throw nanobind::python_error();
    } else if (PyCapsule_SetPointer(place.ptr(), q) != 0) {
      throw nanobind::python_error();
    }
    PyObject* const arguments[] = {nullptr, place.ptr(), state.ptr()};
    const nanobind::object done = nanobind::steal(
        PyObject_Vectorcall(serialize_.ptr(), arguments + 1, 2 | PY_VECTORCALL_ARGUMENTS_OFFSET, nullptr));
    if (!done.is_valid()) throw nanobind::python_error();
    place_ = std::move(place);
  }
};

// The given way to read states of so many numbers; as rows if there is none.
inline std::shared_ptr<const PlannerStates> of_width(std::size_t width, std::shared_ptr<const PlannerStates> states) {
  if (!states) return std::make_shared<const PlannerStates>(width, nanobind::none());
  if (states->width() == width) return states;
  throw std::invalid_argument("states of " + std::to_string(states->width()) + " numbers, not of " +
                              std::to_string(width));
}

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

// How many motions have been found free, and how many not.
struct MotionCounts {
  std::int64_t free = 0, refused = 0;

  void add(bool is_free) { ++(is_free ? free : refused); }
  void reset() { *this = {}; }
};

// Whether validators remember what is asked (motion_memo.hpp), as while a path is shortened.
class Remembering {
 public:
  // From now on, and nothing of what was asked before.
  void begin() { is_on_ = true, ++begun_; }
  void end() { is_on_ = false; }

  bool is_on() const { return is_on_; }
  std::int64_t begun() const { return begun_; }

 private:
  bool is_on_ = false;
  std::int64_t begun_ = 0;
};

// Python's exceptions while a planner asks. Most planners let them pass, but some have threads of their own by then, or
// memory that nobody else frees. So the first one is kept here, and the planner is told to stop.
class PlannerFailure {
 public:
  Remembering remembering;

  // Before a planner runs: `stop` ends its search.
  void arm(nanobind::object stop) {
    stop_ = std::move(stop);
    error_.reset();
  }

  // When it has ended: the exception, or None.
  nanobind::object disarm() {
    stop_.reset();
    const nanobind::object error = std::exchange(error_, nanobind::object());
    return error.is_valid() ? error : nanobind::none();
  }

  // Whether `disarm` will give this exception or an earlier one; false if no planner runs.
  bool keep(nanobind::handle error) {
    if (!stop_.is_valid()) return false;
    if (!error_.is_valid()) error_ = nanobind::borrow(error);
    const nanobind::object stop = stop_;
    stop();
    return true;
  }

 private:
  nanobind::object stop_, error_;
};

// judge(), or false if it fails and the failure is kept. Without `failure`, or if no planner runs, the exception
// passes.
template <class Judge>
bool judged_or_failed(const std::shared_ptr<PlannerFailure>& failure, Judge judge) {
  try {
    return judge();
  } catch (const nanobind::python_error& error) {
    if (failure && failure->keep(error.value())) return false;
    throw;
  }
}

// Ctrl-C while a planner runs: it calls compiled functions only, so no line of Python would ever look for signals.
inline void end_on_signals() {
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

// A list of numbers, for functions in Python.
inline nanobind::list listed(const StateNumbers& q) {
  nanobind::list out;
  for (const double value : q) out.append(value);
  return out;
}

}  // namespace plannercheck
