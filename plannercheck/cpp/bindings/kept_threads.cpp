#include "bindings/kept_threads.hpp"

#include <pthread.h>
#include <sys/resource.h>

#if defined(__linux__)
#include <sched.h>
#endif

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <cstddef>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace plannercheck {
namespace {

// What Linux lets a thread inherit from the one that starts it: its processors, its nice value, its scheduling policy.
struct Inherited {
#if defined(__linux__)
  cpu_set_t processors;
  int nice = getpriority(PRIO_PROCESS, 0);
  int policy = sched_getscheduler(0);
  sched_param priority{};
  Inherited() {
    CPU_ZERO(&processors);
    sched_getaffinity(0, sizeof processors, &processors);
    sched_getparam(0, &priority);
  }
  bool operator==(const Inherited& other) const {
    return nice == other.nice && policy == other.policy && priority.sched_priority == other.priority.sched_priority &&
           CPU_EQUAL(&processors, &other.processors) != 0;
  }
#else
  bool operator==(const Inherited&) const { return true; }
#endif
};

struct KeptThread {
  explicit KeptThread(const Inherited& from) : inherited(from) {}

  const Inherited inherited;
  std::mutex mutex;
  std::condition_variable called;
  std::function<void()> task;
  bool dismissed = false;
};

void dismiss(KeptThread& thread) {
  {
    const std::lock_guard lock(thread.mutex);
    thread.dismissed = true;
  }
  thread.called.notify_one();
}

// Threads without a task.
class IdleThreads {
 public:
  IdleThreads() { threads_.reserve(most_); }  // later there is nobody whom a lack of memory could be told

  // The idle threads of this process: a fork has none of its parent's threads, but may have its pid, if each is the
  // first process of a namespace. Never destroyed, because threads still wait while the process ends.
  static IdleThreads& of_this_process() {
    static std::atomic<IdleThreads*> known{nullptr};
    static const int error = pthread_atfork(nullptr, nullptr, [] { known.store(nullptr); });
    if (error != 0) throw std::system_error(error, std::generic_category(), "pthread_atfork");
    IdleThreads* idle = known.load();
    if (idle != nullptr) return *idle;
    auto own = std::make_unique<IdleThreads>();
    return known.compare_exchange_strong(idle, own.get()) ? *own.release() : *idle;
  }

  // An idle thread that inherited the same, or null. Threads that inherited something else end.
  std::shared_ptr<KeptThread> take(const Inherited& wanted) {
    const std::lock_guard lock(mutex_);
    while (!threads_.empty()) {
      std::shared_ptr<KeptThread> last = std::move(threads_.back());
      threads_.pop_back();
      if (last->inherited == wanted) return last;
      dismiss(*last);
    }
    return nullptr;
  }

  // Whether the thread is kept: more than the machine has processors would wait for nothing.
  bool keep(const std::shared_ptr<KeptThread>& thread) {
    const std::lock_guard lock(mutex_);
    if (threads_.size() >= most_) return false;
    threads_.push_back(thread);
    return true;
  }

 private:
  const std::size_t most_ = std::max(1U, std::thread::hardware_concurrency());
  std::mutex mutex_;
  std::vector<std::shared_ptr<KeptThread>> threads_;
};

void work(const std::shared_ptr<KeptThread>& self) {
  do {
    std::unique_lock lock(self->mutex);
    self->called.wait(lock, [&] { return self->task != nullptr || self->dismissed; });
    if (self->dismissed) return;
    std::exchange(self->task, nullptr)();
  } while (IdleThreads::of_this_process().keep(self));
}

// As long as it lives, threads are started with all signals blocked that a program may wait for: these are for its own
// threads. Errors of a thread itself stay its own.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    for (const int error : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS}) sigdelset(&all, error);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_;
};

}  // namespace

void run_in_a_thread(std::function<void()> task) {
  const Inherited inherited;
  std::shared_ptr<KeptThread> thread = IdleThreads::of_this_process().take(inherited);
  if (thread == nullptr) {
    thread = std::make_shared<KeptThread>(inherited);
    const SignalsBlocked blocked;
    std::thread(work, thread).detach();
  }
  {
    const std::lock_guard lock(thread->mutex);
    thread->task = std::move(task);
  }
  thread->called.notify_one();
}

}  // namespace plannercheck
