// Whether configurations are finite and within limits: many at once, in lanes over their numbers.
//
// In: the limits of each number, which may be infinite. Out: whether all configurations may be judged. This header is
// free of lanes.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

namespace plannercheck {

class JointLimits {
 public:
  JointLimits(std::vector<double> lower, std::vector<double> upper);

  // Whether one configuration is finite and within the limits.
  bool hold(const double* q) const {
    if (width_ < 2) return width_ == 0 || (lower_[0] <= q[0] && q[0] <= upper_[0]);
    TwoMasks within = within_of_two(q, width_ - 2);
    for (std::size_t i = 0; i + 2 < width_; i += 2) within &= within_of_two(q, i);
    return (within[0] & within[1]) != 0;
  }
  // Whether n configurations, one after the other, all are.
  bool hold(const double* q, std::size_t n) const;

 private:
  typedef double Two __attribute__((vector_size(16)));  // every processor has these
  typedef long long TwoMasks __attribute__((vector_size(16)));

  TwoMasks within_of_two(const double* q, std::size_t i) const {
    const Two numbers = two(q + i);
    return (two(&lower_[i]) <= numbers) & (numbers <= two(&upper_[i]));
  }
  static Two two(const double* from) {
    Two numbers;
    std::memcpy(&numbers, from, sizeof numbers);
    return numbers;
  }

  std::size_t width_;
  std::vector<double> lower_, upper_;  // finite, so that infinite numbers are outside; repeated to fill lanes
};

}  // namespace plannercheck
