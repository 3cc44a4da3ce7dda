#include "narrow_phase/support.hpp"

#include "math/double4.hpp"
#include "math/predicates.hpp"
#include "narrow_phase/support_scan.hpp"

namespace plannercheck {
namespace {

// Rounding the difference errs by u, the products by u, the sums by 2u: |error| <= 4u(1 + …) Σ|terms|. 6u leaves room
// for rounding the bound itself. Products that underflow lose at most 2^-1074 each; below kUnderflow nothing is
// trusted, not even exact ties.
constexpr double kDifferenceError = 6 * kRoundoff;
constexpr double kUnderflow = 1e-300;

static_assert(kBlockLanes == kDouble4Lanes);

struct Beyond {
  unsigned sure, unsure;
};

inline Beyond compare_block(const VertexBlock& block, Vec3 v, Vec3 u) {
  const Double4 x = (load_double4(block.x.data()) - v.x) * u.x;
  const Double4 y = (load_double4(block.y.data()) - v.y) * u.y;
  const Double4 z = (load_double4(block.z.data()) - v.z) * u.z;
  const Double4 value = (x + y) + z;
  const Double4 error =
      ((absolute_double4(x) + absolute_double4(y)) + absolute_double4(z)) * kDifferenceError + kUnderflow;
  return {double4_bits(value > error), double4_bits(absolute_double4(value) <= error)};
}

constexpr std::int32_t kScannedEntries = 8;  // more are searched by bisection; removed vertices never have more

class WedgeWalk {
 public:
  WedgeWalk(const Levels& h, const SearchCursor& cursor, Vec3 u, QueryCounters& counters)
      : h_(h), corner_(cursor.point), u_(u), fan_(h.fans[at(cursor.fan())]), counters_(counters) {}

  // A vertex beyond the plane through v at the coarsest level that has one; or -1.
  std::int32_t run() {
    std::int32_t wedge = entry();
    for (;;) {
      ++counters_.blocks;
      const WedgeNode& node = h_.wedges[at(wedge)];
      for (const std::int32_t child : {node.left, node.right}) {
        if (child >= 0 && compare_along(u_, h_.points[at(child)], corner_) > 0) return child;
      }
      if (node.left < 0 && node.right < 0) return -1;
      wedge = next(node);
    }
  }

 private:
  const Levels& h_;
  const Vec3 corner_, u_;
  const WedgeFan& fan_;
  QueryCounters& counters_;

  // Side of u on the plane through the axis and the normal of the facet v a b; positive: counter-clockwise.
  int side(std::int32_t a, std::int32_t b) const {
    return wedge_side(fan_.axis, corner_, h_.points[at(a)], h_.points[at(b)], u_);
  }

  std::int32_t rim(std::int32_t entry) const { return h_.wedges[at(h_.entries[at(fan_.first_entry + entry)])].rim; }

  // The side of u relative to the facet clockwise of entry i; entry i + 1 gives the one counter-clockwise.
  int facet_side(std::int32_t i) const {
    const std::int32_t count = fan_.entries;
    return side(rim((i + count - 1) % count), rim(i % count));
  }

  // The first wedge: the edge between whose two facet normals u lies. Neighbouring normals are less than half a turn
  // apart, as the axis is inside the cone. An edge within a facet has an empty wedge, which is never taken: both its
  // sides are 0, also for u on the far side of the axis. Where u is on the facet's normal, its neighbours hold u.
  std::int32_t entry() const {
    std::int32_t tests = 0;
    std::int32_t found = fan_.entries > kScannedEntries ? search_entries(&tests) : -1;
    if (found < 0) found = scan_entries(&tests);
    counters_.blocks += (tests + kBlockLanes - 1) / kBlockLanes;
    return h_.entries[at(fan_.first_entry + found)];
  }

  std::int32_t scan_entries(std::int32_t* tests) const {
    int clockwise = facet_side(0);
    *tests += 1;
    for (std::int32_t i = 0; i < fan_.entries; ++i) {
      const int counter_clockwise = facet_side(i + 1);
      *tests += 1;
      const bool empty = clockwise == 0 && counter_clockwise == 0;
      if (clockwise >= 0 && counter_clockwise <= 0 && !empty) return i;
      clockwise = counter_clockwise;
    }
    return 0;  // u is the axis: every wedge holds it
  }

  // Searches by bisection in the half turn from the first normal, or in the other half. -1 if the wedge found does not
  // hold u: then u lies in the plane of the axis and the first normal, or along a normal almost opposite to that one.
  std::int32_t search_entries(std::int32_t* tests) const {
    const bool first_half = facet_side(0) >= 0;
    std::int32_t low = first_half ? 0 : fan_.first_half - 1, high = first_half ? fan_.first_half : fan_.entries;
    *tests += 3;
    for (; high - low > 1; *tests += 1) {
      const std::int32_t middle = (low + high) / 2;
      (facet_side(middle) >= 0 ? low : high) = middle;
    }
    const int clockwise = facet_side(low), counter_clockwise = facet_side(low + 1);
    const bool holds = clockwise >= 0 && counter_clockwise <= 0 && (clockwise != 0 || counter_clockwise != 0);
    return holds ? low : -1;
  }

  std::int32_t next(const WedgeNode& node) const {
    if (node.next < 0) return node.next_left;  // the edge vanished into the hole of `left`
    if (node.left >= 0 && side(node.rim, node.left) > 0) return node.next_left;
    if (node.right >= 0 && side(node.right, node.rim) < 0) return node.next_right;
    return node.next;
  }
};

// Moves the stand to the first vertex of the block beyond the plane through it; false if there is none.
inline bool advance(const VertexBlock& block, Vec3 u, SearchCursor& cursor, QueryCounters& counters) {
  ++counters.blocks;
  const Beyond beyond = compare_block(block, cursor.point, u);
  for (unsigned open = beyond.sure | beyond.unsure; open != 0; open &= open - 1) {
    const auto lane = static_cast<std::size_t>(__builtin_ctz(open));
    if ((beyond.sure >> lane & 1U) == 0) {
      ++counters.exact;
      if (compare_along(u, block.point(lane), cursor.point) <= 0) continue;
    }
    cursor = block.cursor(lane);
    return true;
  }
  return false;
}

bool scan_chain(const Levels& h, Vec3 u, SearchCursor& cursor, QueryCounters& counters) {
  const VertexBlock* block = &h.blocks[at(cursor.chain)];
  while (!advance(*block, u, cursor, counters)) {
    if (block++->is_last()) return false;
  }
  return true;
}

bool walk_wedges(const Levels& h, Vec3 u, SearchCursor& cursor, QueryCounters& counters) {
  const std::int32_t child = WedgeWalk(h, cursor, u, counters).run();
  if (child >= 0) cursor = h.cursor(child);
  return child >= 0;
}

// Moves the stand to the vertex beyond the plane through it, at the coarsest level that has one; false if none has.
bool go_beyond(const Levels& h, Vec3 u, SearchCursor& cursor, QueryCounters& counters) {
  if (cursor.chain >= 0) return scan_chain(h, u, cursor, counters);
  return cursor.is_walked() && walk_wedges(h, u, cursor, counters);
}

// Goes down from a vertex that is extreme where it appears to the one that is extreme in the finest level.
SearchCursor descend(const Levels& h, SearchCursor cursor, Vec3 u, QueryCounters& counters) {
  while (go_beyond(h, u, cursor, counters)) {
  }
  return cursor;
}

// Apart, so that the searches that are not descents need no stack.
[[gnu::noinline]] std::int32_t extreme_by_descent(const Levels& h, double x, double y, double z,
                                                  QueryCounters& counters) {
  const Vec3 u{x, y, z};
  return descend(h, cursor_at_top(h, u, counters), u, counters).vertex;
}

}  // namespace

std::int32_t extreme_at_top(const Levels& h, Vec3 u, QueryCounters& counters) {
  return h.depth > 0 ? cursor_at_top(h, u, counters).vertex : extreme_of_top(h, u.x, u.y, u.z, counters);
}

std::int32_t next_beyond(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  SearchCursor cursor = h.cursor(v);
  return go_beyond(h, u, cursor, counters) ? cursor.vertex : -1;
}

std::int32_t beyond_in_ring(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  const std::int32_t first = h.ring_start[at(v)], end = h.ring_start[at(v) + 1];
  counters.blocks += (end - first + kBlockLanes - 1) / kBlockLanes;
  std::int32_t best = v;
  for (std::int32_t i = first; i < end; ++i) {
    const std::int32_t n = h.rings[at(i)];
    if (compare_along(u, h.points[at(n)], h.points[at(best)]) > 0) best = n;
  }
  return best == v ? -1 : best;
}

std::int32_t extreme(const Levels& h, double x, double y, double z, QueryCounters& counters) {
  if (!h.cells.empty()) return extreme_in_cell(h, h.cells.cell({x, y, z}), x, y, z, counters);
  if (h.depth == 0) return extreme_of_top(h, x, y, z, counters);
  return extreme_by_descent(h, x, y, z, counters);
}

std::int32_t extreme_from(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  for (std::int32_t coarser = v; coarser >= 0; coarser = beyond_in_ring(h, v, u, counters)) v = coarser;
  if (h.level[at(v)] == h.depth) v = extreme_at_top(h, u, counters);
  return descend(h, h.cursor(v), u, counters).vertex;
}

}  // namespace plannercheck
