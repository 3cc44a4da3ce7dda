#include "support.hpp"

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include <array>
#include <cstring>

#include "predicates.hpp"

namespace plannercheck {
namespace {

typedef double Quad __attribute__((vector_size(kBlockLanes * 8)));
typedef long long QuadMask __attribute__((vector_size(kBlockLanes * 8)));

inline Quad load(const double* from) {
  Quad q;
  std::memcpy(&q, from, sizeof q);
  return q;
}

inline Quad absolute(Quad q) {
  return reinterpret_cast<Quad>(reinterpret_cast<QuadMask>(q) & (QuadMask{} + 0x7fffffffffffffffLL));
}

inline unsigned quad_bits(QuadMask mask) {
#if defined(__AVX__)
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
  unsigned out = 0;
  for (int i = 0; i < kBlockLanes; ++i) out |= mask[i] != 0 ? 1U << i : 0U;
  return out;
#endif
}

// The difference is rounded (u), the products (u), the sums (2u): |error| <= 4u(1 + …) Σ|terms|; 6u leaves room for
// the rounding of the bound itself. Products that underflow lose at most 2^-1074 each: below kUnderflow nothing is
// trusted, exact ties included.
constexpr double kDifferenceError = 6 * kRoundoff;
constexpr double kUnderflow = 1e-300;

struct Beyond {
  unsigned sure, unsure;
};

inline Beyond compare_block(const Block& block, Vec3 v, Vec3 u) {
  const Quad x = (load(block.x.data()) - v.x) * u.x;
  const Quad y = (load(block.y.data()) - v.y) * u.y;
  const Quad z = (load(block.z.data()) - v.z) * u.z;
  const Quad value = (x + y) + z;
  const Quad error = ((absolute(x) + absolute(y)) + absolute(z)) * kDifferenceError + kUnderflow;
  return {quad_bits(value > error), quad_bits(absolute(value) <= error)};
}

constexpr std::int32_t kScannedEntries = 8;  // more are searched by bisection; removed vertices have no more

class WedgeWalk {
 public:
  WedgeWalk(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters)
      : h_(h), v_(v), corner_(h.points[at(v)]), u_(u), fan_(h.fans[at(h.fan_of[at(v)])]), counters_(counters) {}

  // A vertex beyond the plane through v, at the coarsest level that has one; or -1.
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
  const std::int32_t v_;
  const Vec3 corner_, u_;
  const WedgeFan& fan_;
  QueryCounters& counters_;

  // Sign of u's side of the plane through the axis and the normal of the facet v a b; positive: counter-clockwise.
  int side(std::int32_t a, std::int32_t b) const {
    return wedge_side(fan_.axis, corner_, h_.points[at(a)], h_.points[at(b)], u_);
  }

  std::int32_t rim(std::int32_t entry) const { return h_.wedges[at(h_.entries[at(fan_.first_entry + entry)])].rim; }

  // The side of u on the facet clockwise of entry i; the one counter-clockwise is that of entry i + 1.
  int facet_side(std::int32_t i) const {
    const std::int32_t count = fan_.entries;
    return side(rim((i + count - 1) % count), rim(i % count));
  }

  // The first wedge: the edge between whose two facet normals u lies. Neighbouring normals are less than half a turn
  // apart, as the axis is inside the cone. The wedge of an edge within a facet is empty: both its sides are 0 for u on
  // the far side of the axis, too, so it never is taken; where u is on the facet's normal, its neighbours hold u.
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

  // By bisection in the half turn from the first normal, or in the other; -1 if the wedge found does not hold u, which
  // takes u in the plane of the axis and the first normal, or a normal just about opposite to that.
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

std::int32_t scan_chain(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  const ChainRange chain = h.chains[at(v)];
  const Vec3 corner = h.points[at(v)];
  for (std::int32_t i = 0; i < chain.length; i += kBlockLanes) {
    const Block& block = h.blocks[at(chain.first_block + i / kBlockLanes)];
    ++counters.blocks;
    const Beyond beyond = compare_block(block, corner, u);
    for (unsigned open = beyond.sure | beyond.unsure; open != 0; open &= open - 1) {
      const int lane = __builtin_ctz(open);
      if (i + lane >= chain.length) break;
      const std::int32_t child = block.vertex[at(lane)];
      if ((beyond.sure >> lane & 1U) != 0) return child;
      ++counters.exact;
      if (compare_along(u, h.points[at(child)], corner) > 0) return child;
    }
  }
  return -1;
}

// From a vertex that is extreme where it appears to the one that is extreme in the finest level.
std::int32_t descend(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  for (std::int32_t child = v; child >= 0; child = next_beyond(h, v, u, counters)) v = child;
  return v;
}

}  // namespace

std::int32_t extreme_at_top(const Levels& h, Vec3 u, QueryCounters& counters) {
  std::array<double, kScannedVertices> values;
  const std::size_t count = h.top.size();
  Quad best = Quad{} - __builtin_inf();
  for (std::size_t i = 0; i < count; i += kBlockLanes) {
    const Quad value = (load(&h.top_x[i]) * u.x + load(&h.top_y[i]) * u.y) + load(&h.top_z[i]) * u.z;
    std::memcpy(&values[i], &value, sizeof value);
    best = value > best ? value : best;
  }
  counters.blocks += static_cast<long>(count / kBlockLanes);
  const double highest = larger(larger(best[0], best[1]), larger(best[2], best[3]));
  const bool exact = h.depth > 0;  // below it, first_beyond needs a vertex that is truly extreme
  const double tie = exact ? highest - 2 * kScanError * norm_1(u) * h.largest_coordinate - kUnderflow : highest;
  const Quad ties = Quad{} + tie;
  std::int32_t found = -1;
  for (std::size_t i = 0; i < count; i += kBlockLanes) {
    unsigned candidates = quad_bits(load(&values[i]) >= ties);
    for (; candidates != 0; candidates &= candidates - 1) {
      const std::int32_t v = h.top[i + static_cast<std::size_t>(__builtin_ctz(candidates))];
      if (found < 0) {
        found = v;
        if (!exact) return found;
      } else if (found != v) {
        ++counters.exact;
        if (compare_along(u, h.points[at(v)], h.points[at(found)]) > 0) found = v;
      }
    }
  }
  return found < 0 ? h.top.front() : found;
}

std::int32_t next_beyond(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  if (h.fan_of[at(v)] >= 0) return WedgeWalk(h, v, u, counters).run();
  return scan_chain(h, v, u, counters);
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

std::int32_t extreme(const Levels& h, Vec3 u, QueryCounters& counters) {
  return descend(h, extreme_at_top(h, u, counters), u, counters);
}

std::int32_t extreme_from(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  for (std::int32_t coarser = v; coarser >= 0; coarser = beyond_in_ring(h, v, u, counters)) v = coarser;
  if (h.level[at(v)] == h.depth) v = extreme_at_top(h, u, counters);
  return descend(h, v, u, counters);
}

}  // namespace plannercheck
