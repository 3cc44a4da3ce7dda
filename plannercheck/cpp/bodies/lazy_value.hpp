// A value that the first thread to ask for it computes. Copies share it.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>

namespace plannercheck {

template <class Value>
class LazyValue {
 public:
  // `make` has to give the same value for every caller.
  template <class Make>
  const Value& get(Make make) const {
    std::call_once(state_->once, [&] {
      state_->value = std::make_unique<const Value>(make());
      state_->known.store(state_->value.get(), std::memory_order_release);
    });
    return *state_->value;
  }

  // Null as long as nobody has asked.
  const Value* known() const { return state_->known.load(std::memory_order_acquire); }

 private:
  struct State {
    std::once_flag once;
    std::unique_ptr<const Value> value;  // by pointer, since most bodies are never asked
    std::atomic<const Value*> known = nullptr;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace plannercheck
