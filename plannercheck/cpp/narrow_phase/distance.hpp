// The distance of two posed bodies, between proved bounds, with the points where they are nearest.
//
// In: two posed bodies. Out: the distance of the swollen bodies; where they share a point, by the exact verdict, how
// deep they are in each other, bounded from above. Idea: the descent of gjk on
// the hierarchies goes on past the first separating plane until the gap along its direction and the length of the
// nearest difference meet; where doubles can't tell, double-double goes on from the same vertices.
#pragma once

#include <limits>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();

struct PairDistance {
  bool overlap = false;         // the exact verdict; touching counts
  double lower = 0, upper = 0;  // m; if they overlap both are −(the depth that is found)
  Vec3 on_guest, on_host;       // in the world, on the surfaces; if they overlap what is deepest, and where it has to
  Vec3 direction;               // in the world, from host to guest: along which the guest leaves
};

// `limit`: a distance beyond which a lower bound that exceeds it will do.
PairDistance pair_distance(const PosedBody& guest, const PosedBody& host, double limit, PairCounters& counters);

// A lower bound after a few steps; for bodies that overlap it is that of the balls around them.
double distance_bound(const PosedBody& guest, const PosedBody& host, int rounds, PairCounters& counters);

// How far the balls around two bodies are apart, negative if they meet: a bound of the signed distance.
double ball_gap(const PosedBody& guest, const PosedBody& host);

}  // namespace plannercheck
