// A half-space against another body, exactly: whether they share a point, and how far apart they are.
//
// In: a half-space {M x + t : normal · x <= offset} and another body, posed. Out: verdicts and distances. Idea: with g
// = normal · adj(M), which is normal · M⁻¹ det M, the half-space is {y : g · (y − t) <= offset det M}. Its plane is the
// separating one for every body, and the vertex furthest against g is nearest to it, or furthest in. The height of that
// vertex is computed in doubles with a bound of its rounding; where that leaves the sign open, the vertices in doubt
// are compared exactly. Inflation radii r count along g: height <= |g| r, by squares.
#pragma once

#include "bodies/half_space.hpp"
#include "narrow_phase/distance.hpp"
#include "narrow_phase/pair_frame.hpp"
#include "narrow_phase/part_pair.hpp"

namespace plannercheck {

// Whether a half-space shares a point with another body, of which a solid counts as its hull, as the same vertex
// decides, and a set of parts as all its parts; and the place of the first part that does, −1 for other bodies. Two
// half-spaces are never asked about: as neither moves, no checker has such a pair.
PartContact half_space_contact(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters);

// The distance, or the depth: both are those along the plane's normal, and no shorter way separates the bodies.
// `visit`: as for pair_distance, of bodies that overlap as well.
PairDistance half_space_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters,
                                 const PartVisitor* visit = nullptr);

// A proved lower bound of how far the other body, without its inflation radius, is over the plane, m.
double height_over(const PosedPolytope& half_space, const PosedPolytope& body, PairCounters& counters);

}  // namespace plannercheck
