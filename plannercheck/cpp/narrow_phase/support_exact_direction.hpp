// Extreme vertices along directions that are finer than doubles: in double-double, or exact.
//
// Every comparison is exact for the given direction: doubles first, then double-double, then dyadic numbers.
#pragma once

#include <cstdint>
#include <optional>

#include "bodies/hierarchy.hpp"
#include "math/double_double.hpp"
#include "math/dyadic.hpp"

namespace plannercheck {

class FineDirection {
 public:
  // The direction is the exact sum of its high and low parts, with entries below 2: a direction of largest entry at
  // most 1, turned by a pose that may stretch it by 1e-6, has entries below √3 (1 + 1e-6).
  explicit FineDirection(const DoubleDoubleVec3& u) : fine_(u), rounded_{u.x.high, u.y.high, u.z.high} {}
  explicit FineDirection(const DyadicVec3& u) : FineDirection(direction_of(u)) { exact_ = u; }

  // Up to a relative error of 2^-53 an entry.
  Vec3 rounded() const { return rounded_; }

  // Sign of u · (a − b).
  int sign(Vec3 a, Vec3 b) const;

 private:
  DoubleDoubleVec3 fine_;
  Vec3 rounded_;
  mutable std::optional<DyadicVec3> exact_;  // made when first needed
};

// Index of a vertex that maximises u·p, exactly.
std::int32_t extreme(const Levels& hierarchy, const FineDirection& u);

}  // namespace plannercheck
