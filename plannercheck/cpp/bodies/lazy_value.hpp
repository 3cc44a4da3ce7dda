// A value that the first thread to ask for it computes. Copies share it.
#pragma once

#include <memory>
#include <mutex>

namespace plannercheck {

template <class Value>
class LazyValue {
 public:
  // `make` has to give the same value for every caller.
  template <class Make>
  const Value& get(Make make) const {
    std::call_once(state_->once, [&] { state_->value = std::make_unique<const Value>(make()); });
    return *state_->value;
  }

 private:
  struct State {
    std::once_flag once;
    std::unique_ptr<const Value> value;  // by pointer, since most bodies are never asked
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace plannercheck
