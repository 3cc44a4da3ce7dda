#include "planar/motion_filters_2d.hpp"

namespace plannercheck {
namespace {

// Chords shorter than this have no direction in doubles, m.
constexpr double kShortestChord = 1e-100;

constexpr unsigned kAllLanes = (1U << kLanes) - 1;

unsigned intervals_of(const PlanarGrid& grid) { return (1U << grid.intervals()) - 1; }

}  // namespace

// An interval stays open if neither the axes nor the chord's normal separate the widened chord from the box.
unsigned chords_meet_box(const PlanarGrid& grid, std::int32_t body, const std::array<double, 4>& box,
                         double max_distance) {
  const std::array<double, 4>& path = grid.box(body);
  if (path[0] > box[2] + max_distance || path[2] < box[0] - max_distance || path[1] > box[3] + max_distance ||
      path[3] < box[1] - max_distance)
    return 0;
  const double middle_x = (box[0] + box[2]) / 2, middle_y = (box[1] + box[3]) / 2;
  const double half_x = (box[2] - box[0]) / 2, half_y = (box[3] - box[1]) / 2;
  const double *x = grid.centre(body), *y = x + kPlanarRow;
  unsigned open = 0;
  for (std::size_t i = 0; i < grid.intervals(); i += kLanes) {
    const Lanes x0 = load_lanes(x + i), x1 = load_lanes(x + i + 1), y0 = load_lanes(y + i), y1 = load_lanes(y + i + 1);
    const Lanes dx = x1 - x0, dy = y1 - y0, square = dx * dx + dy * dy;
    const Lanes off_x = larger(smaller(x0, x1) - box[2], box[0] - larger(x0, x1));
    const Lanes off_y = larger(smaller(y0, y1) - box[3], box[1] - larger(y0, y1));
    const Lanes across =
        absolute(dx * (middle_y - y0) - dy * (middle_x - x0)) - (absolute(dx) * half_y + absolute(dy) * half_x);
    const LaneMask beside = (across > 0.0) & (across * across > max_distance * max_distance * square) &
                            (square > kShortestChord * kShortestChord);
    open |= (~bits((off_x > max_distance) | (off_y > max_distance) | beside) & kAllLanes) << i;
  }
  return open & intervals_of(grid);
}

unsigned centres_come_near(const PlanarGrid& grid, std::int32_t a, std::int32_t b, double max_distance) {
  const double *first = grid.centre(a), *second = grid.centre(b);
  unsigned near = 0;
  for (std::size_t i = 0; i <= grid.intervals(); i += kLanes) {
    const Lanes x = load_lanes(first + i) - load_lanes(second + i);
    const Lanes y = load_lanes(first + kPlanarRow + i) - load_lanes(second + kPlanarRow + i);
    near |= bits(x * x + y * y <= broadcast(max_distance * max_distance)) << i;
  }
  return (near | near >> 1) & intervals_of(grid);
}

}  // namespace plannercheck
