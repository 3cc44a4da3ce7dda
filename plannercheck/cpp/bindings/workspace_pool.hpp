// A core (checker, certifier) with the workspaces that its callers have returned: what they learnt serves the next
// call, on however many threads.
//
// In: work for a workspace, or for rows on several threads. Out: what the work writes, and the sums of what all
// workspaces have counted. A core has a type Workspace, new_workspace(), and take_counters(workspace).
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <atomic>
#include <concepts>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"

namespace plannercheck {

template <class Core>
class Pooled {
 public:
  using Workspace = typename Core::Workspace;
  using Counters = decltype(Core::take_counters(std::declval<Workspace&>()));

  template <class... Arguments>
    requires std::constructible_from<Core, Arguments...>
  explicit Pooled(Arguments&&... arguments) : core_(std::forward<Arguments>(arguments)...) {}

  const Core& core() const { return core_; }

  Pooled(const Pooled&) = delete;
  Pooled& operator=(const Pooled&) = delete;
  ~Pooled() { delete handy_.load(); }

  // work(workspace), with one that no other caller has.
  template <class Work>
  void with_workspace(Work work) {
    Held held(handy_.exchange(nullptr, std::memory_order_acquire));
    if (!held) held = spare_one();
    work(**held);
    put_back(std::move(held));
  }

  // An array of a value for each of n rows, without the GIL: work(first row, how many, their values, workspace). Each
  // thread takes two thirds of its part of the rows that are left, again and again: larger shares are judged faster,
  // and a thread that starts late, or whose core has other work, takes less. A thread half as fast as the other still
  // ends with it.
  template <class Value, class Work>
  auto of_rows(std::size_t n, int threads, Work work) {
    std::vector<Value> values(n);
    const auto wanted = static_cast<std::size_t>(std::max(threads, 1));
    const std::size_t least = wanted > 1 ? least_share(n, wanted) : std::max<std::size_t>(n, 1);
    const std::size_t takers = std::clamp<std::size_t>((n + least - 1) / least, 1, wanted);
    std::atomic<std::size_t> taken{0};
    without_gil(takers, [&](std::size_t) {
      with_workspace([&](Workspace& w) {
        std::size_t first = 0, count = 0;
        const auto take = [&] {
          first = taken.load();
          do {
            count = std::min(std::max(least, 2 * (n - first) / (3 * takers) / kBlock * kBlock), n - first);
          } while (!taken.compare_exchange_weak(first, first + count));
          return count > 0;
        };
        while (take()) {
          work(first, count, values.data() + first, w);
          poll_interruption();
        }
      });
    });
    return output_array(values, {n});
  }

  // of_rows, row by row: of(row, workspace) returns a row's value.
  template <class Value, class Of>
  auto of_each_row(std::size_t n, int threads, Of of) {
    return of_rows<Value>(n, threads, [&](std::size_t first, std::size_t count, Value* values, Workspace& w) {
      for (std::size_t i = 0; i < count; ++i) {
        if (i > 0) poll_interruption();
        values[i] = static_cast<Value>(of(first + i, w));
      }
    });
  }

  // The sums so far. Python's objects must not be made under the lock: its garbage collector may ask again from within.
  Counters counted() {
    Held held(handy_.exchange(nullptr, std::memory_order_acquire));
    if (held) put_back(std::move(held), false);
    const std::lock_guard lock(mutex_);
    for (const Held& workspace : spare_) total_ += Core::take_counters(**workspace);
    return total_;
  }

 private:
  // A workspace that nobody else has. Its type is complete only where the core is compiled.
  using Held = std::unique_ptr<std::shared_ptr<Workspace>>;

  static constexpr std::size_t kBlock = 16;  // rows that are judged together, at most

  // So small that threads end at nearly the same time.
  static std::size_t least_share(std::size_t n, std::size_t threads) {
    constexpr std::size_t kSharesOfThread = 32;
    const std::size_t rows = (n + threads * kSharesOfThread - 1) / (threads * kSharesOfThread);
    return rows < kBlock ? std::max<std::size_t>(rows, 1) : (rows + kBlock - 1) / kBlock * kBlock;
  }

  Core core_;
  std::mutex mutex_;
  std::vector<Held> spare_;
  std::atomic<std::shared_ptr<Workspace>*> handy_{nullptr};  // one more, for calls that can't wait for the lock
  Counters total_;

  Held spare_one() {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return std::make_unique<std::shared_ptr<Workspace>>(core_.new_workspace());
    Held last = std::move(spare_.back());
    spare_.pop_back();
    return last;
  }

  void put_back(Held held, bool at_hand = true) {
    std::shared_ptr<Workspace>* none = nullptr;
    if (at_hand && handy_.compare_exchange_strong(none, held.get(), std::memory_order_release)) {
      static_cast<void>(held.release());
      return;
    }
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(held));
  }
};

}  // namespace plannercheck
