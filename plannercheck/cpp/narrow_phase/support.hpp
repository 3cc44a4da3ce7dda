// Extreme vertices: the vertex of a body that is furthest along a direction, in O(log n).
//
// Every comparison of the walk is on the difference of two vertices, filtered with its own error bound and exact where
// the filter fails: a walk that compares rounded products can stop far from the extreme vertex. Where a body has cells
// of directions, those of one are scanned in floats instead, and what their rounding leaves is compared like that, too;
// of bodies of at most kUnlayered rounded products are compared: the vertex found is then extreme up to kScanError.
#pragma once

#include "bodies/hierarchy.hpp"
#include "math/vec.hpp"

namespace plannercheck {

// What a query touched; costs an increment each, and shows the logarithm.
struct QueryCounters {
  long blocks = 0;  // blocks of four vertices compared, the wedge tests of one node counting as one, of an entry four
  long exact = 0;   // comparisons that the filter left over
};

// The scan's vertex v has u·v >= max u·p − 2 · kScanError |u|_1 largest_coordinate: three products and two sums.
inline constexpr double kScanError = 4 * 0x1p-53;

// Index of a vertex that maximises u·p over all points, exact for the given doubles (but see the scan above).
std::int32_t extreme(const Levels& levels, Vec3 u, QueryCounters& counters);

// The same search in steps, which ask for the memory that the next one reads: for callers with several under way.
class Descent {
 public:
  // From the top, or the direction's cell.
  void start(const Levels& levels, Vec3 u, QueryCounters& counters);

  // Looks at one block, or the blocks of a cell, or walks all wedges of a vertex; false if the vertex is found.
  bool step(QueryCounters& counters);

  std::int32_t vertex() const { return stand_.vertex; }
  Vec3 point() const { return stand_.point; }

 private:
  const Levels* levels_ = nullptr;
  const Block* block_ = nullptr;  // of the chain that is scanned; else none
  const Cell* cell_ = nullptr;    // of the direction, where the body has cells
  bool has_asked_ = false;        // for that cell's blocks
  Vec3 direction_;
  Stand stand_;

  void arrive();
  void stand_at(std::int32_t vertex);
  bool step_in_cell(QueryCounters& counters);
};

// The same from any vertex v: up by rings to a vertex that is extreme at the level where it appears, and down from
// there. Each ring leads to a coarser level, so this is O(log n) wherever it starts.
std::int32_t extreme_from(const Levels& levels, std::int32_t v, Vec3 u, QueryCounters& counters);

// The furthest along u of v's neighbours at the level where v appears, or -1 if v itself is, exactly: v is then extreme
// at that level. Top vertices have no ring.
std::int32_t beyond_in_ring(const Levels& levels, std::int32_t v, Vec3 u, QueryCounters& counters);

// The vertex beyond the plane through v with normal u at the coarsest level below v's that has one; or -1. `v` must be
// extreme along u at the level where it appears (or among the top vertices).
std::int32_t next_beyond(const Levels& levels, std::int32_t v, Vec3 u, QueryCounters& counters);

// As `extreme`, among the top vertices only.
std::int32_t extreme_at_top(const Levels& levels, Vec3 u, QueryCounters& counters);

}  // namespace plannercheck
