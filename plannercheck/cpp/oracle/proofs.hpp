// Proofs about two posed bodies, checked from their definition; and a search for one.
//
// In: two posed bodies. Out: whether a direction proves them apart, or a mixture of vertices proves that they share a
// point; or a proof, found by Gilbert, Johnson and Keerthi's descent in integers. A body is all points within its
// inflation radius of its hull.
#pragma once

#include <vector>

#include "oracle/posed_points.hpp"

namespace plannercheck::oracle {

struct Pair {
  PosedPoints p, r;

  // Brings both to a common unit.
  Pair(PosedPoints first, PosedPoints second);
};

// Convex weights, not divided by their sum, of differences of vertices of both bodies.
struct Mixture {
  std::vector<std::size_t> first, second;
  std::vector<Integer> weights;
};

// Whether the first body lies further along the direction than the second: the least product with a difference of
// vertices exceeds the direction's length times the sum of the inflation radii. `every`: without a filter.
bool proves_apart(const Pair& pair, const Vector& direction, bool every);

// Whether weights >= 0, not all 0, mix a point of each hull whose distance is at most the sum of the inflation radii.
bool proves_shared(const Pair& pair, const Mixture& mixture);

struct Proof {
  enum class Kind { kNone, kApart, kShared } kind = Kind::kNone;
  Vector direction;  // if apart
  Mixture mixture;   // if shared
};

// A checked proof. There is none only if the search takes too many steps, which is a fault of the search.
Proof prove(const Pair& pair, bool every);

}  // namespace plannercheck::oracle
