// Work without Python's lock (GIL), in threads that Python may leave behind at its end.
//
// In: a scope. Out: no lock inside of it, or the lock once more. Idea: at its end, Python (before 3.14) ends each
// daemon thread that asks for the lock by `pthread_exit`, which unwinds the thread's stack. A destructor that must not
// throw, as in nanobind's guards, or a `catch (...)` turns the unwinding into std::terminate: the whole process aborts,
// whatever its exit code was to be. Here such a thread sleeps forever instead, as in Python 3.14, and the process ends
// without it.
#pragma once

#include <Python.h>

#include <chrono>
#include <thread>

namespace plannercheck {

// Takes the lock for a thread; does not come back where Python has ended.
inline void take_gil(PyThreadState* state) noexcept {
  try {
    PyEval_RestoreThread(state);
  } catch (...) {  // the unwinding of pthread_exit; Python's own functions throw nothing
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
}

// As long as it lives, this thread does not hold the lock.
class GilReleased {
 public:
  GilReleased() : before_(released_), state_(PyEval_SaveThread()) { released_ = state_; }
  ~GilReleased() {
    take_gil(state_);
    released_ = before_;
  }
  GilReleased(const GilReleased&) = delete;
  GilReleased& operator=(const GilReleased&) = delete;

 private:
  friend class GilTakenBack;

  static inline thread_local PyThreadState* released_ = nullptr;  // of the innermost scope

  PyThreadState* before_;
  PyThreadState* state_;
};

// Inside of a `GilReleased` of the same thread: as long as it lives, the thread holds the lock again.
class GilTakenBack {
 public:
  GilTakenBack() : state_(GilReleased::released_) { take_gil(state_); }
  ~GilTakenBack() { PyEval_SaveThread(); }
  GilTakenBack(const GilTakenBack&) = delete;
  GilTakenBack& operator=(const GilTakenBack&) = delete;

 private:
  PyThreadState* state_;
};

}  // namespace plannercheck
