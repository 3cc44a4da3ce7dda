// Workspaces that callers have returned: what they learnt serves the next call, on however many threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace plannercheck {

// Pointer: owns a workspace.
template <class Pointer>
class WorkspacePool {
 public:
  // work(workspace), with one from the pool or from create(); then returned(workspace), one caller at a time.
  template <class Create, class Work, class Returned>
  void with_one(Create create, Work work, Returned returned) {
    Pointer workspace;
    {
      const std::lock_guard lock(mutex_);
      if (!spare_.empty()) {
        workspace = std::move(spare_.back());
        spare_.pop_back();
      }
    }
    if (!workspace) workspace = create();
    work(*workspace);
    const std::lock_guard lock(mutex_);
    returned(*workspace);
    spare_.push_back(std::move(workspace));
  }

  // What `look` returns, while no caller is in `returned`. It must not run Python, whose garbage collector may ask
  // again from within.
  template <class Look>
  auto alone(Look look) {
    const std::lock_guard lock(mutex_);
    return look();
  }

 private:
  std::mutex mutex_;
  std::vector<Pointer> spare_;
};

// part(first, last) over parts of n rows, one a thread; an exception of any is thrown at the end.
template <class Part>
void in_parallel(std::size_t n, int threads, Part part) {
  // Joined at the end of their scope, also where the system has no more of them and throws.
  struct Joined {
    std::vector<std::thread> threads;
    ~Joined() {
      for (std::thread& thread : threads) thread.join();
    }
  };
  const std::size_t count =
      std::min<std::size_t>(static_cast<std::size_t>(std::max(threads, 1)), std::max<std::size_t>(n, 1));
  std::mutex mutex;
  std::exception_ptr failure;  // an exception that leaves a thread would end the process
  const auto guarded = [&](std::size_t k) {
    try {
      part(n * k / count, n * (k + 1) / count);
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
    }
  };
  {
    Joined others;
    for (std::size_t k = 1; k < count; ++k) others.threads.emplace_back(guarded, k);
    guarded(0);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace plannercheck
