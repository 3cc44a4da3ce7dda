// Threads that are joined at the end of their scope, also where the system has no more of them and throws.
#pragma once

#include <thread>
#include <vector>

namespace plannercheck {

struct JoinedThreads {
  std::vector<std::thread> threads;
  ~JoinedThreads() {
    for (std::thread& thread : threads) thread.join();
  }
};

}  // namespace plannercheck
