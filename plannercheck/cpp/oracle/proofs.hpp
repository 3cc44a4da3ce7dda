// Proofs about two posed bodies, checked from their definition; and a search for one.
//
// In: two posed bodies. Out: whether a direction proves them apart, or a mixture of vertices proves that they share a
// point; or a proof, found by Gilbert, Johnson and Keerthi's descent in whole numbers. A body is all points within its
// inflation radius of its vertices' hull.
#pragma once

#include <cstdint>
#include <vector>

#include "oracle/posed_points.hpp"

namespace plannercheck::oracle {

struct Pair {
  PosedPoints p, r;

  // Brings both to a common unit.
  Pair(PosedPoints first, PosedPoints second);
};

// Convex weights, to be divided by their sum, of the differences of vertices of both bodies.
struct Mixture {
  std::vector<std::size_t> first, second;
  std::vector<Integer> weights;
};

// All points of the first body lie further along the direction than all of the second: the least product with a
// difference of vertices exceeds the direction's length times the sum of the inflation radii. `every`: without a
// filter.
bool proves_apart(const Pair& pair, const Vector& direction, bool every);

// Weights of at least 0, not all 0, mix a point of each hull, no further apart than the sum of the inflation radii.
bool proves_shared(const Pair& pair, const Mixture& mixture);

struct Proof {
  enum class Kind { kNone, kApart, kShared } kind = Kind::kNone;
  Vector direction;  // if apart
  Mixture mixture;   // if shared
};

// A proof that was checked. None only where the search takes too many steps: a fault of the search.
Proof prove(const Pair& pair, bool every);

}  // namespace plannercheck::oracle
