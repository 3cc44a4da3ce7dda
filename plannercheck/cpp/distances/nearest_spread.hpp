// How far from each other all nearest pairs of points of two bodies are: where they are one pair, the distance has a
// gradient.
//
// In: two posed hulls that are apart (or a hull over a half-space), the normal that proves a lower bound of their
// distance. Out: a bound, m; infinite where none is proved.
//
// Proof. Along the normal n, let A's vertices begin at height h, and let upper and lower be the bounds of the distance.
// The nearest points x of A lie below h + e, e = upper − lower and rounding: else x would be too far from all of B. If
// all vertices but those of a set N begin at h + t, a mixture x of vertices has at most the part e / t outside N, and
// is within d = e / t times the diameter of the hull of N. N with one vertex: all nearest points of A are within d of
// it, and those of B are a fixed vector away, as the nearest difference is unique. An edge of A and an edge of B: two
// nearest points differ by a vector that is within 2 d of a multiple of either edge, so it is at most 2 (d_A + d_B) /
// sin of the angle between the edges. As the set of the lowest vertices is connected by edges, N grows by the lowest
// neighbour.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "narrow_phase/distance.hpp"

namespace plannercheck {

// The edges of a hull: the neighbours of vertex v are ends[starts[v]] to ends[starts[v + 1] − 1].
struct HullEdges {
  std::vector<std::int32_t> starts, ends;
};
HullEdges edges_of(const Polytope& body);

// `normal`: from b to a, of length 1 up to rounding; it proves found.lower.
double nearest_spread(const PosedPolytope& body_a, const HullEdges& edges_a, const PosedPolytope& body_b,
                      const HullEdges& edges_b, const PairDistance& found, PairCounters& counters);

}  // namespace plannercheck
