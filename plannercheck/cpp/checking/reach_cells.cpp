#include "checking/reach_cells.hpp"

#include <cmath>
#include <utility>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kCellsAtOnce = kLanes;

}  // namespace

ReachCells::ReachCells(const std::vector<std::vector<Vec3>>& centres, std::vector<ReachCut> cuts,
                       std::vector<std::size_t> first_cut, double margin, double relative)
    : cuts_(std::move(cuts)), first_cut_(std::move(first_cut)), margin_(margin), relative_(relative) {
  for (const std::vector<Vec3>& set : centres) {
    const std::size_t whole = (set.size() + kCellsAtOnce - 1) / kCellsAtOnce * kCellsAtOnce;
    Centres out;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < whole; ++k) out.along[i].push_back(set[k < set.size() ? k : set.size() - 1][i]);
    }
    centres_.push_back(std::move(out));
  }
}

bool ReachCells::is_clear(std::size_t body, const ReachObstacle& obstacle) const {
  for (std::size_t cut = first_cut_[body]; cut < first_cut_[body + 1]; ++cut) {
    if (is_clear(cuts_[cut], obstacle)) return true;
  }
  return false;
}

// Whether all centres are further from the obstacle's box than the ball's radius with all margins.
bool ReachCells::is_clear(const ReachCut& cut, const ReachObstacle& obstacle) const {
  const double room = cut.radius + obstacle.inflation_radius + margin_ + relative_ * (cut.extent + obstacle.size);
  if (!std::isfinite(room)) return false;
  const auto& m = obstacle.pose.m;
  const Vec3 middle = obstacle.pose.rotate_back(obstacle.pose.translation()) + 0.5 * (obstacle.low + obstacle.high);
  const Vec3 half = 0.5 * (obstacle.high - obstacle.low);
  const auto& along = centres_[cut.centres].along;
  for (std::size_t k = 0; k < along[0].size(); k += kCellsAtOnce) {
    const Lanes x = load_lanes(&along[0][k]), y = load_lanes(&along[1][k]), z = load_lanes(&along[2][k]);
    Lanes square{};
    for (std::size_t j = 0; j < 3; ++j) {
      const Lanes offset = ((m[j] * x + m[4 + j] * y) + m[8 + j] * z) - middle[j];
      const Lanes beyond = larger(absolute(offset) - half[j], Lanes{});
      square += beyond * beyond;
    }
    if (bits(square > room * room) != (1U << kLanes) - 1) return false;  // NaN counts as near
  }
  return true;
}

}  // namespace plannercheck
