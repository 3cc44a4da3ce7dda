#include "motions/swept_boxes.hpp"

namespace plannercheck {
namespace {

// Poses are off rigid by at most 3.6e-6, and the inverse rotation is taken to be the transposed one. Rounding is far
// below that, but for what cancels: that is for the limit, which has the motion's slack (motion_rounding.hpp).
constexpr double kSeenError = 1e-5;

}  // namespace

SweptBoxes::SweptBoxes(MotionGrid& grid, std::int32_t body, const FrameBox& box, std::size_t middle)
    : frame_(grid.pose(body, middle)) {
  const Vec3 centre = 0.5 * (box.low + box.high), half = 0.5 * (box.high - box.low);
  const auto& f = frame_.m;
  for (std::size_t first = 0; first <= grid.intervals(); first += kStep) {
    const Lanes* const m = grid.poses(body, first);
    const std::array<Lanes, 3> way{m[3] - f[3], m[7] - f[7], m[11] - f[11]};
    for (std::size_t k = 0; k < 3; ++k) {
      Lanes at_centre = (f[k] * way[0] + f[k + 4] * way[1]) + f[k + 8] * way[2], around{};
      for (std::size_t j = 0; j < 3; ++j) {
        const Lanes entry = (f[k] * m[j] + f[k + 4] * m[j + 4]) + f[k + 8] * m[j + 8];
        at_centre = at_centre + entry * centre[static_cast<int>(j)];
        around = around + absolute(entry) * half[static_cast<int>(j)];
      }
      store_lanes(&low_[k][first], at_centre - around);
      store_lanes(&high_[k][first], at_centre + around);
    }
  }
}

FrameBox SweptBoxes::around(std::size_t from, std::size_t to) const {
  std::array<double, 3> low, high;
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = low_[k][from], high[k] = high_[k][from];
    for (std::size_t i = from + 1; i <= to; ++i) {
      low[k] = smaller(low[k], low_[k][i]), high[k] = larger(high[k], high_[k][i]);
    }
  }
  const FrameBox box{{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
  const double room = kSeenError * (norm_1(box.low) + norm_1(box.high));
  const Vec3 grown{room, room, room};
  return {box.low - grown, box.high + grown};
}

}  // namespace plannercheck
