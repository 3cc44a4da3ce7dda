// Work of the core that may take long: without the GIL, on as many threads as asked for, and given up on Ctrl-C.
//
// In: work. Out: what it writes, or its exception; KeyboardInterrupt, if Python's signal handler raises it, as soon as
// the work polls (math/interruption.hpp).
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>

#include "bindings/gil.hpp"
#include "bindings/kept_threads.hpp"
#include "math/interruption.hpp"

namespace plannercheck {

// Runs Python's handlers of signals that have come; they run in Python's main thread only.
inline void ask_python() {
  const GilTakenBack gil;
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

// The threads of one call.
class CallThreads {
 public:
  CallThreads() = default;
  CallThreads(const CallThreads&) = delete;
  CallThreads& operator=(const CallThreads&) = delete;

  // Waits for all started threads to end, also when the system has no more threads and throws.
  ~CallThreads() {
    given_up_ = true;
    std::unique_lock lock(mutex_);
    one_ended_.wait(lock, [this] { return all_ended(); });
  }

  // part(k) for k = 0 … count − 1, one a thread; the first exception of any is thrown when all have ended.
  template <class Part>
  void run(std::size_t count, const Part& part) {
    for (std::size_t k = 1; k < count; ++k, ++started_) start(part, k, count);
    guarded(&ask_python, [&] { part(0); });
    guarded(&ask_python, [this] { wait_for_others(); });
    const std::unique_lock lock(mutex_);  // which the last one may still hold
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  // Threads end at nearly the same time, and being woken up would take longer than that.
  static constexpr int kYields = 50;

  std::atomic<bool> given_up_{false};
  std::mutex mutex_;
  std::condition_variable one_ended_;
  std::size_t started_ = 0;
  std::atomic<std::size_t> ended_{0};
  std::exception_ptr failure_;  // an exception that leaves a thread would end the process

  template <class Part>
  void start(const Part& part, std::size_t k, std::size_t count) {
    try {
      run_in_a_thread([this, &part, k] {
        guarded(nullptr, [&] { part(k); });
        const std::lock_guard lock(mutex_);
        ++ended_;
        one_ended_.notify_one();
      });
    } catch (const std::system_error&) {
      throw std::runtime_error("the system has " + std::to_string(k) + " of the " + std::to_string(count) +
                               " threads asked for: ask for fewer");
    }
  }

  bool all_ended() const { return ended_ == started_; }

  template <class Work>
  void guarded(Interruptible::Ask ask, Work work) {
    try {
      const Interruptible scope(given_up_, ask);
      work();
    } catch (const Interrupted&) {  // the thread that gave up says why
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      given_up_ = true;
    }
  }

  void wait_for_others() {
    for (int k = 0; k < kYields && !all_ended(); ++k) std::this_thread::yield();
    while (!all_ended()) {
      {
        std::unique_lock lock(mutex_);
        if (one_ended_.wait_for(lock, kAskingInterval, [this] { return all_ended(); })) return;
      }
      if (!given_up_) ask_python();
    }
  }
};

// part(k) for k = 0 … count − 1, one a thread, without the GIL.
template <class Part>
void without_gil(std::size_t count, const Part& part) {
  const GilReleased released;
  CallThreads().run(count, part);
}

// As long as it lives, this thread keeps the GIL until its loops have polled for the first time that they look at the
// clock: giving it back and taking it again would take a tenth of a usual motion's time (measured).
class GilReleasedWhenLong {
 public:
  GilReleasedWhenLong() : before_(innermost_), scope_(given_up_, &release_or_ask, {}) { innermost_ = this; }
  ~GilReleasedWhenLong() { innermost_ = before_; }
  GilReleasedWhenLong(const GilReleasedWhenLong&) = delete;
  GilReleasedWhenLong& operator=(const GilReleasedWhenLong&) = delete;

 private:
  static inline thread_local GilReleasedWhenLong* innermost_ = nullptr;

  GilReleasedWhenLong* before_;
  std::optional<GilReleased> released_;
  std::atomic<bool> given_up_{false};
  Interruptible scope_;  // ends before the GIL is taken again

  static void release_or_ask() { innermost_->released_ ? ask_python() : void(innermost_->released_.emplace()); }
};

// work() in this thread, without the GIL.
template <class Work>
void without_gil(Work work) {
  without_gil(1, [&](std::size_t) { work(); });
}

}  // namespace plannercheck
