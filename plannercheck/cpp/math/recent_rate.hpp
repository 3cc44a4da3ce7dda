// The recent rate of an event, for steps that save time only if the event is frequent, or rare.
//
// In: tries, and in how many of them the event happened. Out: the share among about the latest `window` tries, older
// tries counting half; and, where the share is against a try, whether another try is due, which is so every `retry`-th
// time.
#pragma once

#include <algorithm>
#include <cstdint>

namespace plannercheck {

class RecentRate {
 public:
  // Begins as if the event had happened in `happened` of `tried` tries.
  explicit constexpr RecentRate(std::uint32_t window, std::uint32_t retry = 1, std::uint32_t tried = 0,
                                std::uint32_t happened = 0)
      : window_(window), retry_(retry), tried_(tried), happened_(happened) {}

  void add(std::uint32_t tried, std::uint32_t happened) {
    tried_ += tried, happened_ += happened;
    while (tried_ > window_) halve();
  }
  // Makes the next tries count as much as all before.
  void halve() { tried_ /= 2, happened_ /= 2; }

  // Whether the event happens in at least one of so many tries; true if there were no tries.
  bool is_at_least_one_in(std::uint32_t tries) const { return happened_ * tries >= tried_; }
  bool is_at_most(double share) const { return happened_ <= share * tried_; }
  bool is_above(const RecentRate& other) const { return happened_ * other.tried_ > other.happened_ * tried_; }

  // Call it where the share is against a try, for `passed` tries that are passed over: true at the first one, and after
  // each `retry` more.
  bool is_due(std::uint32_t passed = 1) {
    const bool due = wait_ == 0;
    if (due) wait_ = retry_;
    wait_ -= std::min(passed, wait_);
    return due;
  }

 private:
  std::uint32_t window_, retry_, tried_, happened_;
  std::uint32_t wait_ = 0;  // until the next one is due
};

}  // namespace plannercheck
