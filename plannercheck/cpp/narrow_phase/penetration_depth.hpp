// How deep two hulls are in each other: the length of the shortest translation that separates them, between proved
// bounds.
//
// In: two posed bodies whose hulls share a point, or nearly do. Out: bounds of the depth of the hulls without their
// inflation radii, the direction and the points. Idea: the depth is the origin's distance from the boundary of the
// Minkowski difference. A polytope inside of the difference expands where it is nearest to the origin
// (expanding_polytope.hpp): its distance is a lower bound, and each extreme vertex asked for gives an upper bound along
// its direction. Where doubles do not tell the polytope's faces, the exact hull of the vertices found takes its place.
// A nearest point z of the boundary is not inside of the polytope, so it is beyond the plane of a face, of normal n and
// at most `upper` from the origin: n · z >= lower and |z| <= upper, so n and z / |z| differ by at most
// √(2 (upper − lower) / upper).
#pragma once

#include <limits>

#include "narrow_phase/gjk.hpp"

namespace plannercheck {

struct HullDepth {
  // m; `lower` is proved if it is above 0. It is 0 or less where no shared point is proved. Moving A by `upper` along
  // the direction separates the hulls up to contact.
  double lower = 0, upper = std::numeric_limits<double>::infinity();
  Vec3 direction;  // in the world, from B to A, of length 1 up to rounding
  // No direction in which the depth is least is further from this one, as a chord; infinite where that is not proved.
  double turn = std::numeric_limits<double>::infinity();
  Vec3 on_body_a;  // in the world: A's point that is deepest in B along it, next to B's boundary after the translation
};

// `start`: what `hull_distance` found; its vertices only save time. `doubles`: off, exact hulls are built from the
// start.
HullDepth hull_depth(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start,
                     PairCounters& counters, bool doubles = true);

}  // namespace plannercheck
