#include "narrow_phase/support_exact_direction.hpp"

#include <array>

#include "math/predicates.hpp"
#include "narrow_phase/support.hpp"

namespace plannercheck {
namespace {

// The direction's entries are below kLargestEntry. Rounding them errs by u of that (by 2^-1074 where they are tiny),
// the difference, products and sums by 4u: below 5u kLargestEntry |e|_1. Products that underflow are below kUnderflow.
constexpr double kLargestEntry = 2, kRoundedError = 8 * kLargestEntry * kRoundoff, kUnderflow = 1e-290;

// In double-double the difference is exact. A direction rounded from a dyadic one errs by 2^-105 kLargestEntry an
// entry, products by 2^-102 kLargestEntry |e|_1, each of two sums by as much: below 2^-100 kLargestEntry |e|_1.
constexpr double kFineError = 0x1p-99 * kLargestEntry;

// The range in which Dekker's split does not overflow and the lower parts do not underflow within kFineError.
constexpr double kSmallestFine = 1e-150, kLargestFine = 1e150;

// Top vertices may be extreme if their rounded products lie within this of the highest, times |u|_1 · largest
// coordinate: twice the scan's error and that of rounding the direction.
constexpr double kTopDoubt = 2 * (kScanError + 2 * kRoundoff);

// The vertex with the highest rounded product, unless one of those in doubt is higher.
std::int32_t extreme_at_top(const Levels& h, const FineDirection& direction) {
  const Vec3 u = direction.rounded();
  std::array<double, kUnlayered> values;
  std::size_t highest = 0;
  for (std::size_t i = 0; i < h.top.size(); ++i) {
    values[i] = dot(h.points[at(h.top[i])], u);
    if (values[i] > values[highest]) highest = i;
  }
  const double tie = values[highest] - kTopDoubt * norm_1(u) * h.largest_coordinate - kUnderflow;
  std::int32_t found = h.top[highest];
  for (std::size_t i = 0; i < h.top.size(); ++i) {
    if (!(values[i] >= tie) || h.top[i] == found) continue;  // comparing it with itself would need the exact test
    if (direction.sign(h.points[at(h.top[i])], h.points[at(found)]) > 0) found = h.top[i];
  }
  return found;
}

// A vertex of v's chain beyond the plane through v, at the coarsest level that has one; or -1.
std::int32_t next_beyond(const Levels& h, std::int32_t v, const FineDirection& direction) {
  const ChainRange chain = h.chains[at(v)];
  for (std::int32_t i = 0; i < chain.length; ++i) {
    const std::int32_t child = h.blocks[at(chain.first_block + i / kBlockLanes)].id(at(i % kBlockLanes));
    if (direction.sign(h.points[at(child)], h.points[at(v)]) > 0) return child;
  }
  return -1;
}

}  // namespace

int FineDirection::sign(Vec3 a, Vec3 b) const {
  const Vec3 e = a - b;
  const double value = dot(rounded_, e), size = norm_1(e);
  if (std::fabs(value) > kRoundedError * size + kUnderflow) return value > 0 ? 1 : -1;
  const bool level = (rounded_.x == 0 || e.x == 0) && (rounded_.y == 0 || e.y == 0) && (rounded_.z == 0 || e.z == 0);
  if (level && !exact_) return 0;  // in double-double, what rounds to 0 is 0
  if (size > kSmallestFine && size < kLargestFine) {
    const double fine = dot(fine_, difference(a, b)).high;
    if (std::fabs(fine) > kFineError * size) return fine > 0 ? 1 : -1;
  }
  if (!exact_) exact_.emplace(fine_);
  return dot(*exact_, DyadicVec3(a) - DyadicVec3(b)).sign();
}

std::int32_t extreme(const Levels& h, const FineDirection& u) {
  std::int32_t v = extreme_at_top(h, u);
  for (std::int32_t child = v; child >= 0; child = next_beyond(h, v, u)) v = child;
  return v;
}

}  // namespace plannercheck
