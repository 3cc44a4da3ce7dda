#include "math/interruption.hpp"

namespace plannercheck {

thread_local Interruptible* interruptible = nullptr;

Interruptible::Interruptible(std::atomic<bool>& given_up, Ask ask)
    : given_up_(given_up), ask_(ask), before_(interruptible), asked_(std::chrono::steady_clock::now()) {
  interruptible = this;
}

Interruptible::~Interruptible() { interruptible = before_; }

void Interruptible::ask_if_due() {
  countdown_ = kPolls;
  const auto now = std::chrono::steady_clock::now();
  if (now - asked_ < kAskingInterval) return;
  asked_ = now;
  ask_();
}

}  // namespace plannercheck
