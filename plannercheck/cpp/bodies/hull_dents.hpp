// How nearly a solid fills its hull.
//
// In: a solid and its hull. Out: its dent, a part s < 1 such that the solid holds its hull P shrunk about the hull's
// centre c by s, P' = c + (1 − s)(P − c). Meshes of convex links are such solids: they are their hulls up to rounding,
// or up to some shallow dents.
//
// Proof: P = {c + y : q·y <= 1 for all polar points q}. Of each triangle, one polar point is known by which all corners
// have q·y > 1 − s; then so has each of its points, and none is in P', where q·y <= 1 − s. As P' hangs together and
// meets no triangle, the solid winds around all of it as often as around one point of it, which is told exactly.
#pragma once

#include <limits>

namespace plannercheck {

struct Polytope;
struct Solid;

// Of what is no convex body, if nothing is known.
inline constexpr double kUnknownDent = std::numeric_limits<double>::infinity();

// kUnknownDent if the solid is open, hollow at its centre or has a deep dent.
double dent_of(const Polytope& hull, const Solid& solid);

}  // namespace plannercheck
