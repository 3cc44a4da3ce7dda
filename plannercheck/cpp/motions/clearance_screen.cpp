#include "motions/clearance_screen.hpp"

namespace plannercheck {
namespace {

using ClearanceRow = std::array<Lanes, kGridRow / kStep>;

// A ball's centre at the states of a grid.
class CentrePath {
 public:
  CentrePath(const MotionGrid& grid, std::int32_t link, const Vec3& centre) : intervals_(grid.intervals()) {
    for (std::size_t first = 0; first <= intervals_; first += kStep) {
      const Lanes* const m = grid.link(link, first);
      for (std::size_t k = 0; k < 3; ++k) {
        const Lanes* const r = m + 4 * k;
        at_[k][first / kStep] = (r[0] * centre.x + r[1] * centre.y) + (r[2] * centre.z + r[3]);
      }
    }
  }

  // The intervals that do not lie, with both ends, nearer to the middle state than the clearance there leaves.
  unsigned near_middle(const ClearanceGrid& clearances, double distance) const {
    const Vec3 middle = place(intervals_ / 2);
    const double length = clearances.from(middle) - distance;
    if (!(length > 0)) return ~0U;
    unsigned within = 0;
    for (std::size_t first = 0; first <= intervals_; first += kStep) {
      const std::size_t g = first / kStep;
      const Lanes x = at_[0][g] - middle.x, y = at_[1][g] - middle.y, z = at_[2][g] - middle.z;
      within |= bits((x * x + y * y) + z * z < broadcast(length * length)) << first;
    }
    return ~(within & within >> 1);
  }

  // The intervals on which the clearances at both ends leave less than the way.
  unsigned near_between(const ClearanceGrid& clearances, double distance) const {
    ClearanceRow clearance;
    for (std::size_t g = 0; g * kStep <= intervals_; ++g)
      clearance[g] = clearances.from(at_[0][g], at_[1][g], at_[2][g]);
    unsigned open = 0;
    for (std::size_t first = 0; first < intervals_; first += kStep) {
      const std::size_t g = first / kStep;
      Lanes square{};
      for (const ClearanceRow& row : at_) {
        const Lanes way = next_lanes(row[g], row[g + 1]) - row[g];
        square = square + way * way;
      }
      const Lanes left = clearance[g] + next_lanes(clearance[g], clearance[g + 1]) - 2 * distance;
      const unsigned clear = bits(left > Lanes{}) & bits(left * left > square);
      open |= (~clear & ((1U << kLanes) - 1)) << first;
    }
    return open;
  }

 private:
  std::size_t intervals_;
  std::array<ClearanceRow, 3> at_;

  Vec3 place(std::size_t state) const {
    const std::size_t g = state / kStep, lane = state % kStep;
    return {at_[0][g][lane], at_[1][g][lane], at_[2][g][lane]};
  }
};

}  // namespace

unsigned near_by_clearances(const PartClearances& clearances, const CertifiedPair& pair, const MotionFilters& filters,
                            const MotionGrid& grid, double beyond, unsigned near) {
  const PartClearances::Look look = clearances.look(pair.a, pair.b);
  if (look.grid == nullptr) return near;
  const double apart = filters.apart(pair) + beyond;
  unsigned open = 0;
  for (const SmallBall& ball : *look.balls) {
    const CentrePath path(grid, look.link, ball.centre);
    unsigned left = near & ~open & path.near_middle(*look.grid, ball.radius + apart);
    if (left != 0) left &= path.near_between(*look.grid, ball.radius + apart);
    open |= left;
    if (open == near) break;
  }
  return open;
}

}  // namespace plannercheck
