// The motions that a planner has asked for lately, and whether they are free: what shortens a path asks for a sixth of
// its motions again.
//
// In: the ends of a motion. Out: the answer for the very same numbers, if it is still known. A motion's place in the
// table depends on its numbers only, and a later one with the same place takes it over. Callers hold the GIL.
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

  enum Answer : std::uint8_t { kRefused, kFree, kUnknown };

  // Forgets what was asked before the search with this number. Another search rarely asks for it, unless it has the
  // same seed, as where searches are measured.
  void begin_search(std::int64_t number) {
    if (number == search_) return;
    search_ = number;
    std::fill(answers_.begin(), answers_.end(), kUnknown);
  }

  Answer find(const double* q0, const double* q1) const {
    const std::size_t place = place_of(q0, q1);
    const double* const known = ends_.data() + place * 2 * width_;
    const std::size_t size = width_ * sizeof(double);
    if (std::memcmp(known, q0, size) != 0 || std::memcmp(known + width_, q1, size) != 0) return kUnknown;
    return answers_[place];
  }

  void keep(const double* q0, const double* q1, bool is_free) {
    const std::size_t place = place_of(q0, q1);
    std::memcpy(ends_.data() + place * 2 * width_, q0, width_ * sizeof(double));
    std::memcpy(ends_.data() + (place * 2 + 1) * width_, q1, width_ * sizeof(double));
    answers_[place] = is_free ? kFree : kRefused;
  }

 private:
  static constexpr int kPlaceBits = 8;
  static constexpr std::size_t kPlaces = std::size_t{1} << kPlaceBits;

  std::size_t width_;
  std::int64_t search_ = 0;
  std::vector<double> ends_;
  std::vector<Answer> answers_;

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
