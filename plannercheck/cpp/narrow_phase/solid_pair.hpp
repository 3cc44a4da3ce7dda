// Whether two bodies share a point if their hulls do; at least one body is a solid.
//
// In: two posed bodies. Out: whether their sets share a point, and by what. Idea: a descent in both trees, along pairs
// of nodes whose boxes meet, searches for triangles that meet. If no triangles meet, one vertex of each connected part
// of the surfaces decides. Suppose that no triangles meet and both bodies share a point x. If x is on a triangle of A,
// it is on no triangle of B, so B winds around x. No triangle of B crosses the connected part of A's surface with x, so
// B winds equally often around each point of this part, also around its vertex. If x is on no triangle, take the region
// of all points that a path without crossing a triangle connects with x. Both bodies wind around all of this region, so
// it is bounded, and its boundary has a point on a triangle of one body. The other body winds around this point, and
// the first case applies. Bodies with inflation radii are these sets with all points within the radii; the same holds
// for triangles closer than both radii together.
#pragma once

#include <cstdint>

#include "narrow_phase/intersection.hpp"
#include "narrow_phase/pair_frame.hpp"
#include "narrow_phase/posed_solid.hpp"

namespace plannercheck {

// What two bodies share.
struct SolidContact {
  enum class Kind { kNone, kTriangles, kAInB, kBInA, kParts, kHalfSpace };
  Kind kind = Kind::kNone;
  std::int32_t a = -1, b = -1;  // triangles or parts by their places in the trees; or a vertex of the inner body

  explicit operator bool() const { return kind != Kind::kNone; }
};

struct SolidCounters {
  long boxes = 0, triangles = 0, exact = 0, points = 0;  // node tests, triangle pairs, those left open, winding numbers
};

// What saves time; verdicts do not depend on it.
struct SolidOptions {
  bool boxes = true;          // only children whose box meets the other one are followed
  bool nearest_first = true;  // of these
  bool lanes = true;          // triangles are tested eight at a time, before the exact test
  bool reaching_out = true;   // parts that reach out of the other body's box are not inside of it
  bool part_trees = true;     // of sets of parts, only those are tested whose boxes come near the other body's
};

// `guess`: where the pair met last; it only saves time.
SolidContact triangles_contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                               PairCounters& counters, const SolidOptions& options = {},
                               SolidCounters* counted = nullptr);

// Tells whether two bodies' hulls share a point.
class HullTest {
 public:
  virtual bool share() = 0;
  // Whether that decided the bodies as well, see PairVerdict.
  virtual bool settled() const = 0;

 protected:
  ~HullTest() = default;
};

// What is known of a pair of solids from poses before; it only saves time.
struct SolidHistory {
  SolidContact contact;   // where they met last
  bool hulls_met = true;  // as far as is known: then trees are tried before hulls
  bool wants_plane;       // whether hulls that are apart leave a plane, which is worth more than what trees tell
  int patience = kLeastPatience;  // pairs of nodes that are looked at before hulls are tested

  // As long as a test of hulls takes (measured); what a batch begins with; and what it grows to while that test is in
  // vain again and again, as it is for large bodies near contact (measured).
  static constexpr int kLeastPatience = 24, kFirstPatience = 8 * kLeastPatience, kMostPatience = 32 * kLeastPatience;
};

// Whether two bodies share a point. Pairs whose hulls mostly share one are sought in the trees at once; their hulls are
// tested if that takes long. `trees_first`: whether they may be.
bool solids_share_with(const PosedPolytope& a, const PosedPolytope& b, HullTest& hulls, bool trees_first,
                       SolidHistory& history, PairCounters& counters);

// Whether two bodies, no triangles of which meet, share a point: a part of one of them lies in the other one.
bool are_nested(const PosedPolytope& a, const PosedPolytope& b);

// Whether two bodies share a point, given the verdict on their hulls.
inline bool bodies_share(const PairVerdict& hulls, const PosedPolytope& a, const PosedPolytope& b,
                         PairCounters& counters) {
  return hulls.shared && (hulls.settles || triangles_contact(a, b, {}, counters));
}

}  // namespace plannercheck
