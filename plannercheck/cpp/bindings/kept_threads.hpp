// Threads for the parts of calls, which stay for later calls.
//
// In: tasks. Out: each runs in a thread of its own. Idea: starting a thread and joining it takes as long as some
// hundred states; waking a waiting thread is three times as fast.
#pragma once

#include <functional>

namespace plannercheck {

// Runs the task, which must not throw, in a thread that no other task has: one that waits, or a new one. Its
// processors, nice value and scheduling policy are the caller's; its arithmetic is plain, as `PlainFloats`
// (plain_floats.hpp) guards all calls. Throws std::system_error where the system has no more threads.
void run_in_a_thread(std::function<void()> task);

}  // namespace plannercheck
