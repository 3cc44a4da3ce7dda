// Long calls that can be given up: by Ctrl-C, while a loop of the core runs.
//
// In: loops that call `poll_interruption` once a block of their work. Out: an exception out of the loop if the call has
// to end; its results are dropped. Idea: a call declares in each of its threads that it may be interrupted
// (`Interruptible`). One thread, which may call Python, asks for signals every few hundredths of a second; the others
// read a flag. In threads without this declaration, as within a planner of OMPL, nothing happens.
#pragma once

#include <atomic>
#include <chrono>

namespace plannercheck {

// How long a call goes on at most before it asks, unless its blocks take longer.
inline constexpr std::chrono::milliseconds kAskingInterval{50};

// Thrown in the threads of a call that another one of its threads gives up.
struct Interrupted {};

// As long as it lives, the loops of this thread may be given up.
class Interruptible {
 public:
  using Ask = void (*)();  // throws if the call is to end
  using Clock = std::chrono::steady_clock;

  // given_up: common to the threads of a call. ask: null in threads that do not ask. asked: the last time; with none,
  // the first look at the clock asks.
  Interruptible(std::atomic<bool>& given_up, Ask ask, Clock::time_point asked = Clock::now());
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  void poll() {
    if (given_up_.load(std::memory_order_relaxed)) throw Interrupted{};
    if (ask_ != nullptr && --countdown_ == 0) ask_if_due();
  }

 private:
  static constexpr int kPolls = 16;  // between two looks at the clock

  std::atomic<bool>& given_up_;
  Ask ask_;
  Interruptible* before_;
  int countdown_ = kPolls;
  Clock::time_point asked_;

  void ask_if_due();
};

// What this thread's loops poll; null if they can't be given up.
extern thread_local Interruptible* interruptible;

inline void poll_interruption() {
  if (interruptible != nullptr) interruptible->poll();
}

}  // namespace plannercheck
