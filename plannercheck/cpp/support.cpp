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

class WedgeWalk {
 public:
  WedgeWalk(const Hierarchy& h, std::int32_t v, Vec3 u, QueryCounters& counters)
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
  const Hierarchy& h_;
  const std::int32_t v_;
  const Vec3 corner_, u_;
  const WedgeFan& fan_;
  QueryCounters& counters_;

  // Sign of u's side of the plane through the axis and the normal of the facet v a b; positive: counter-clockwise.
  int side(std::int32_t a, std::int32_t b) const {
    return wedge_side(fan_.axis, corner_, h_.points[at(a)], h_.points[at(b)], u_);
  }

  std::int32_t rim(std::int32_t entry) const { return h_.wedges[at(h_.entries[at(fan_.first_entry + entry)])].rim; }

  // The first wedge: the edge between whose two facet normals u lies. Neighbouring normals are less than half a turn
  // apart, as the axis is inside the cone. The wedge of an edge within a facet is empty: both its sides are 0 for u on
  // the far side of the axis, too, so it never is taken; where u is on the facet's normal, its neighbours hold u.
  std::int32_t entry() const {
    const std::int32_t count = fan_.entries;
    int clockwise = side(rim(count - 1), rim(0));
    for (std::int32_t i = 0; i < count; ++i) {
      const int counter_clockwise = side(rim(i), rim((i + 1) % count));
      const bool empty = clockwise == 0 && counter_clockwise == 0;
      if (clockwise >= 0 && counter_clockwise <= 0 && !empty) return h_.entries[at(fan_.first_entry + i)];
      clockwise = counter_clockwise;
    }
    return h_.entries[at(fan_.first_entry)];  // u is the axis: every wedge holds it
  }

  std::int32_t next(const WedgeNode& node) const {
    if (node.next < 0) return node.next_left;  // the edge vanished into the hole of `left`
    if (node.left >= 0 && side(node.rim, node.left) > 0) return node.next_left;
    if (node.right >= 0 && side(node.right, node.rim) < 0) return node.next_right;
    return node.next;
  }
};

std::int32_t scan_chain(const Hierarchy& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
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

}  // namespace

std::int32_t extreme_at_top(const Hierarchy& h, Vec3 u, QueryCounters& counters) {
  std::array<double, kTopVertices> values;
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

std::int32_t next_beyond(const Hierarchy& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  if (h.fan_of[at(v)] >= 0) return WedgeWalk(h, v, u, counters).run();
  return scan_chain(h, v, u, counters);
}

std::int32_t extreme(const Hierarchy& h, Vec3 u, QueryCounters& counters) {
  std::int32_t v = extreme_at_top(h, u, counters);
  for (std::int32_t child = v; child >= 0; child = next_beyond(h, v, u, counters)) v = child;
  return v;
}

}  // namespace plannercheck
