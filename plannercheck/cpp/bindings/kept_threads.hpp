// Threads for the parts of calls, kept from one call to the next.
//
// In: tasks. Out: each runs in a thread of its own. Idea: to start a thread and to wait for its end takes as long as
// some hundred states; one that waits for its next task is there in a third of that.
#pragma once

#include <functional>

namespace plannercheck {

// Runs the task, which must not throw, in a thread that no other task has: one that waits, or a new one. Its
// processors, nice value and scheduling policy are the caller's; its arithmetic is plain, as `PlainFloats`
// (plain_floats.hpp) guards all calls. Throws std::system_error where the system has no more threads.
void run_in_a_thread(std::function<void()> task);

}  // namespace plannercheck
