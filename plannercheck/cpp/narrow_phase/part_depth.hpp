// How deep two bodies are in each other, between proved bounds, where one is a solid or a set of parts.
//
// In: two posed bodies. Out: as pair_distance, with closer bounds where such bodies overlap. Idea: what separates the
// bodies separates any two convex pieces of them, so the deepest pair of pieces gives a lower bound. Each translation
// after which the exact verdict finds the bodies apart is an upper bound: along the way out of the deepest pair, and
// of others, of the hulls, and along both frames' axes, the shortest one is sought by bisection. If the deepest pair
// leaves last, both bounds are the same up to rounding.
//
// Pieces of a set are its parts. A solid whose connected shells are all convex is their union: these are its pieces.
// Pieces of any other solid are its triangles, and, if it is closed, the balls and the box inside of it
// (solid_interior.hpp) and a ball around a point of the other body. They do not fill it, so its bounds may stay open.
#pragma once

#include "narrow_phase/distance.hpp"

namespace plannercheck {

// The signed distance of any two bodies. Looks at all pieces that overlap, for which pair_distance does not take the
// time.
PairDistance signed_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters);

}  // namespace plannercheck
