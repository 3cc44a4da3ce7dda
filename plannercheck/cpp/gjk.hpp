// The point of conv(P) − conv(R) nearest to the origin, in doubles, with certificates of its own (Gilbert, Johnson and
// Keerthi 1988, on the hierarchies' extreme vertices). Needs no interior point, so it serves flat and swollen bodies,
// and as the second filter after the game: its bounds involve neither facets nor the inverse of a pose.
#pragma once

#include <array>

#include "pair.hpp"

namespace plannercheck {

struct Proximity {
  Answer answer = Answer::kUndecided;
  Vec3 direction;      // in the world, from host to guest: of a separating plane, or the best found
  Vec3 direction_low;  // what double-double adds to it; 0 if found in doubles
  Vec3 point;          // in the world: of both bodies if they share one
  // Pairs of vertices whose differences mix the nearest point found, or one of both bodies.
  int count = 0;
  std::array<std::int32_t, 4> guest, host;
};

// `hint`: a world direction to begin with.
Proximity nearest_points(const PosedBody& guest, const PosedBody& host, Vec3 hint, PairCounters& counters);

}  // namespace plannercheck
