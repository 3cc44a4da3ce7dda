// Whether two bodies share a point of which at least one is a solid, once their hulls do.
//
// In: two posed bodies. Out: whether their sets share a point, and by what. Idea: triangles that meet are sought in
// both trees at once, down pairs of nodes whose boxes meet. If no triangles meet, bodies can only share a point if one
// of them lies in the other: take a point x that both share, and suppose that it is on a triangle of A. Then it is on
// none of B, so B winds around it, and as often around each point of the part of A's surface that hangs together with
// x, as no triangle of B crosses it: also around that part's vertex. If x is on no triangle at all, the region of
// points that can be reached from x without crossing triangles is bounded, since both bodies wind around all of it, and
// its boundary has a point on a triangle of one body, around which the other one winds. So one vertex of each part
// tells. Bodies with inflation radii are these sets with all points within the radii; the same holds for triangles
// closer than both radii together.
#pragma once

#include <cstdint>

#include "narrow_phase/pair_frame.hpp"
#include "narrow_phase/posed_solid.hpp"

namespace plannercheck {

// What two bodies share.
struct SolidContact {
  enum class Kind { kNone, kTriangles, kAInB, kBInA };
  Kind kind = Kind::kNone;
  std::int32_t a = -1, b = -1;  // two triangles by their places in the trees; or a vertex of the inner body

  explicit operator bool() const { return kind != Kind::kNone; }
};

struct SolidCounters {
  long boxes = 0, triangles = 0, exact = 0, points = 0;  // node tests, triangle pairs, those left open, winding numbers
};

// `guess`: where the pair met last; it only saves time.
SolidContact solids_contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                            PairCounters& counters, SolidCounters* counted = nullptr);

// Whether a hull does not tell all about a pair.
inline bool is_of_solids(const PosedPolytope& a, const PosedPolytope& b) { return a.body->solid || b.body->solid; }

// Whether two bodies, no triangles of which meet, share a point: a part of one of them lies in the other one.
bool are_nested(const PosedPolytope& a, const PosedPolytope& b);

// Whether two bodies whose hulls share a point do so themselves.
inline bool solids_share(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters) {
  return !is_of_solids(a, b) || solids_contact(a, b, {}, counters);
}

}  // namespace plannercheck
