// How nearly a solid fills its hull: its dents, by the hull's facets.
//
// In: a solid and its hull P = {c + y : q·y <= 1 for all polar points q}. Out: for each facet q a depth s < 1, such
// that the solid holds P' = {c + y : q·y <= 1 − s for all q}. Meshes of convex links are such solids: they are their
// hulls up to rounding, or up to some shallow dents.
//
// Proof: for each triangle, one facet is known with q·y > 1 − s at all corners. Then all points of the triangle have
// q·y > 1 − s, so the triangle does not meet P'. P' is convex and meets no triangle, so the solid winds equally often
// around all points of P'. For the centre c, this winding number is decided exactly.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

struct Polytope;
struct Solid;

// The depth of dents of which nothing is known.
inline constexpr double kUnknownDent = std::numeric_limits<double>::infinity();

struct DentedFacet {
  std::int32_t facet;  // by its polar point
  double height;       // 1 − s
};

struct HullDents {
  double deepest = 0;               // of all facets; 0 if the body is its hull
  double others = 0;                // of those that are not named here
  std::vector<DentedFacet> facets;  // those with the deepest dents

  bool are_known() const { return deepest < kUnknownDent; }
};

// Not known if the solid is open, hollow at its centre, or has a deep dent.
HullDents dents_of(const Polytope& hull, const Solid& solid);

// The 1 − s of each facet of a body whose dents are known.
std::vector<double> facet_heights(const Polytope& body);

// A part t <= 1 such that c + t y is in P', for a point c + y of the hull of a body whose dents are known. `error`: of
// q·y.
double scale_past_dents(const Polytope& body, Vec3 y, double error);

}  // namespace plannercheck
