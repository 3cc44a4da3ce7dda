// Whether one pair of points of two bodies is nearest, or deepest: then the distance has a gradient.
//
// In: two posed convex bodies, or pairs of parts of two others, and their distances. Out: a bound of how far the
// nearest pairs of points are from the given one, m; infinite where it is not proved that there is one only.
//
// Proof. A and B are convex, without their inflation radii; all differences x − y make up the convex set A − B.
//
// - Apart, the nearest difference z is unique. The normal n proves that all differences reach `lower` along it, and
//   |z| <= upper, so n · z / |z| >= lower / upper: n and z / |z| differ by at most t = √(2 (upper − lower) / upper).
// - A overlaps B: every direction in which the depth is least is the normal of a facet of A − B, and
//   penetration_depth.hpp bounds how far these are from n.
// - Over a half-space, n is the normal: t = 0.
//
// The nearest points of A are on its face F that is lowest along a direction d within t of n. A step between vertices
// with n · step > t |step| ascends along d. Descents along edges lead from any vertex to F, and F is connected by
// edges, so all steps that may not ascend lead to a set of vertices that holds F. The same holds for B and −n. If one
// of both sets is a single vertex, or both are edges that are not parallel, one pair of points only has the difference
// z. If A and B overlap, z is unique up to how far the normals of the facets of these sets that are within t of n are
// from it.
//
// Several pairs of parts are nearest where parts share vertices. If all pairs whose lower bound is no more than the
// least upper one have the same two sets, all nearest points are in the hulls of these, which are parts of A and B.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "narrow_phase/distance.hpp"

namespace plannercheck {

// How far the directions of nearest differences are from that of `found` at most, as chords; infinite where A and B are
// so near that rounding leaves them open.
double normal_turn(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairDistance& found,
                   PairCounters& counters);

// The edges of a hull: the neighbours of vertex v are ends[starts[v]] to ends[starts[v + 1] − 1].
struct HullEdges {
  std::vector<std::int32_t> starts, ends;
};
// For a part of a set or a triangle: edges from each vertex to each other vertex.
HullEdges edges_of(const Polytope& body);

// A and B are convex. `found`: their distance; its direction proves the lower bound.
double nearest_spread(const PosedPolytope& body_a, const HullEdges& edges_a, const PosedPolytope& body_b,
                      const HullEdges& edges_b, const PairDistance& found, PairCounters& counters);

// The spread of bodies apart, from pairs of their parts: add at least all that are no further apart than the bodies.
class NearestParts {
 public:
  void add(const PosedPolytope& body_a, const HullEdges& edges_a, const PosedPolytope& body_b, const HullEdges& edges_b,
           const PairDistance& found, PairCounters& counters);
  double spread() const;

 private:
  struct Candidate {
    double lower, spread;
    std::vector<Vec3> face_a, face_b;  // vertices in the bodies' frames, sorted
  };
  std::vector<Candidate> candidates_;
  double upper_ = kNoLimit;
};

}  // namespace plannercheck
