#include "math/interruption.hpp"

namespace plannercheck {

thread_local Interruptible* interruptible = nullptr;

Interruptible::Interruptible(std::atomic<bool>& given_up, Ask ask, Clock::time_point asked)
    : given_up_(given_up), ask_(ask), before_(interruptible), asked_(asked) {
  interruptible = this;
}

Interruptible::~Interruptible() { interruptible = before_; }

void Interruptible::ask_if_due() {
  countdown_ = kPolls;
  const auto now = Clock::now();
  if (now - asked_ < kAskingInterval) return;
  asked_ = now;
  ask_();
}

}  // namespace plannercheck
