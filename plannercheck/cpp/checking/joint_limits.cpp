#include "checking/joint_limits.hpp"

#include <algorithm>
#include <limits>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kRows = static_cast<std::size_t>(kLanes);  // so many rows fill lanes, whatever their width

// The limits of kRows configurations, one after the other.
std::vector<double> repeated(const std::vector<double>& limits) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  std::vector<double> out;
  for (std::size_t row = 0; row < kRows; ++row) {
    for (const double limit : limits) out.push_back(std::max(std::min(limit, kLargest), -kLargest));
  }
  return out;
}

}  // namespace

JointLimits::JointLimits(std::vector<double> lower, std::vector<double> upper)
    : width_(lower.size()), lower_(repeated(lower)), upper_(repeated(upper)) {}

bool JointLimits::hold(const double* q, std::size_t n) const {
  LaneMask within = LaneMask{} - 1;
  std::size_t row = 0;
  for (; row + kRows <= n; row += kRows) {
    for (std::size_t i = 0; i < lower_.size(); i += kRows) {
      const Lanes numbers = load_lanes(q + row * width_ + i);
      within &= (load_lanes(&lower_[i]) <= numbers) & (numbers <= load_lanes(&upper_[i]));
    }
  }
  bool all = bits(within) == (1U << kLanes) - 1;
  for (; row < n; ++row) all &= hold(q + row * width_);
  return all;
}

}  // namespace plannercheck
