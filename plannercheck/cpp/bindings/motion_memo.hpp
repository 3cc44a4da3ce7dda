// Recent motions, and whether they are free: a shortening of a path asks for a sixth of its motions again. A search for
// a path does not repeat motions, so nothing is remembered then (Remembering).
//
// In: the ends of a motion, and who finds the answer. Out: the answer, from the table if the very same numbers are in
// it. A motion's place in the table depends on its numbers only, and a later motion with the same place replaces it.
// Callers hold the GIL.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace plannercheck {

class MotionMemo {
 public:
  explicit MotionMemo(std::size_t width) : width_(width), ends_(kPlaces * 2 * width), answers_(kPlaces, kUnknown) {}

  // Nothing is known in a period other than the last call's.
  template <class Find>
  bool answer(std::int64_t period, const double* q0, const double* q1, Find find) {
    if (period != period_) forget(period);
    const std::size_t place = place_of(q0, q1);
    if (holds(place, q0, q1)) return answers_[place] == kFree;
    const bool is_free = find();  // may ask for other motions from within
    double* const ends = ends_.data() + place * 2 * width_;
    std::copy_n(q0, width_, ends);
    std::copy_n(q1, width_, ends + width_);
    answers_[place] = is_free ? kFree : kRefused;
    return is_free;
  }

 private:
  enum Answer : std::uint8_t { kRefused, kFree, kUnknown };

  static constexpr int kPlaceBits = 8;
  static constexpr std::size_t kPlaces = std::size_t{1} << kPlaceBits;

  std::size_t width_;
  std::int64_t period_ = 0;
  std::vector<double> ends_;
  std::vector<Answer> answers_;

  void forget(std::int64_t period) {
    period_ = period;
    std::fill(answers_.begin(), answers_.end(), kUnknown);
  }

  bool holds(std::size_t place, const double* q0, const double* q1) const {
    const double* const known = ends_.data() + place * 2 * width_;
    const std::size_t size = width_ * sizeof(double);
    if (std::memcmp(known, q0, size) != 0 || std::memcmp(known + width_, q1, size) != 0) return false;
    return answers_[place] != kUnknown;
  }

  // By Fibonacci hashing, whose best bits are the upper ones.
  std::size_t place_of(const double* q0, const double* q1) const {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;
    std::uint64_t sum = 0;
    for (std::size_t c = 0; c < width_; ++c) {
      sum = std::rotl(sum, 9) ^ (std::bit_cast<std::uint64_t>(q0[c]) + 3 * std::bit_cast<std::uint64_t>(q1[c]));
    }
    return static_cast<std::size_t>(sum * kGolden >> (64 - kPlaceBits));
  }
};

}  // namespace plannercheck
