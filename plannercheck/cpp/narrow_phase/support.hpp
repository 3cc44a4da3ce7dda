// Extreme vertices: the vertex of a body that is furthest along a direction, in O(log n).
//
// The walk compares two vertices by the sign of the product with their difference: in doubles where the error bound
// allows, else exactly. A walk that compared rounded products could stop far from the extreme vertex. Where a body has
// cells of directions, the vertices of one cell are scanned in floats, and the candidates that remain are compared as
// above. Bodies of at most kUnlayered vertices are scanned by rounded products, exact up to kScanError.
#pragma once

#include "bodies/hierarchy.hpp"
#include "math/vec.hpp"

namespace plannercheck {

// What a query cost; the counts show that it is logarithmic. Counting takes one increment each.
struct QueryCounters {
  long blocks = 0;  // blocks of four vertices compared; the wedge tests of a node count as one, of an entry as four
  long exact = 0;   // comparisons that the filter did not decide
};

// The scan's vertex v has u·v >= max u·p − 2 · kScanError |u|_1 largest_coordinate: three products and two sums.
inline constexpr double kScanError = 4 * 0x1p-53;

// Index of a vertex that maximises u·p over all points: exact for the given doubles, except for the scan above.
// The direction goes in by its entries, which stay in registers; a Vec3 would go through memory.
std::int32_t extreme(const Levels& levels, double x, double y, double z, QueryCounters& counters);
inline std::int32_t extreme(const Levels& levels, Vec3 u, QueryCounters& counters) {
  return extreme(levels, u.x, u.y, u.z, counters);
}

// As `extreme`, from any vertex v: up through the rings to a vertex that is extreme at the level where it appears, then
// down. Each ring leads to a coarser level, so this is O(log n) from any vertex.
std::int32_t extreme_from(const Levels& levels, std::int32_t v, Vec3 u, QueryCounters& counters);

// The vertex furthest along u among v's neighbours at the level where v appears; or -1 if v is further than all of
// them, exactly, and so extreme at that level. Top vertices have no ring.
std::int32_t beyond_in_ring(const Levels& levels, std::int32_t v, Vec3 u, QueryCounters& counters);

// At the coarsest level below v's that has one, the vertex beyond the plane through v with normal u; or -1. `v` must be
// extreme along u at the level where it appears (or among the top vertices).
std::int32_t next_beyond(const Levels& levels, std::int32_t v, Vec3 u, QueryCounters& counters);

// As `extreme`, among the top vertices only.
std::int32_t extreme_at_top(const Levels& levels, Vec3 u, QueryCounters& counters);

}  // namespace plannercheck
