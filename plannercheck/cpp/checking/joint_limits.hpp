// Whether configurations are finite and within limits: many at once, in lanes over their numbers.
//
// In: the limits of each number, which may be infinite. Out: whether all configurations may be judged. This header is
// free of lanes.
#pragma once

#include <cstddef>
#include <vector>

namespace plannercheck {

class JointLimits {
 public:
  JointLimits(std::vector<double> lower, std::vector<double> upper);

  // Of one configuration.
  bool hold(const double* q) const {
    bool within = true;
    for (std::size_t i = 0; i < width_; ++i) {
      within &= lower_[i] <= q[i];
      within &= q[i] <= upper_[i];
    }
    return within;
  }
  // Of n configurations, one after the other.
  bool hold(const double* q, std::size_t n) const;

 private:
  std::size_t width_;
  std::vector<double> lower_, upper_;  // finite, so that no infinite number is within, and so often that lanes are full
};

}  // namespace plannercheck
