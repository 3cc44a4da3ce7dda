#include "support.hpp"

#include <array>
#include <vector>

#include "predicates.hpp"
#include "quads.hpp"
#include "simd.hpp"

namespace plannercheck {
namespace {

// The difference is rounded (u), the products (u), the sums (2u): |error| <= 4u(1 + …) Σ|terms|; 6u leaves room for
// the rounding of the bound itself. Products that underflow lose at most 2^-1074 each: below kUnderflow nothing is
// trusted, exact ties included.
constexpr double kDifferenceError = 6 * kRoundoff;
constexpr double kUnderflow = 1e-300;

// Rounding direction and coordinates to floats, |entries| <= 1, errs by 2^-24 each, so do products; two sums of at most
// 3 add 5 · 2^-24: a product errs by 14 · 2^-24 at most, underflow included, times the direction's largest entry.
// Vertices further below the highest than twice that are not extreme.
constexpr float kFloatTie = 32 * 0x1p-24F;
constexpr double kSmallestFloat = 1e-20, kLargestFloat = 1e20;  // of that entry: else the direction is scaled
constexpr double kSmallestDirection = 1e-290, kLargestDirection = 1e290;

constexpr std::size_t kBatch = 4;      // blocks of a scan that are searched for candidates at a time
constexpr std::size_t kFewBlocks = 8;  // more are first searched by the largest products of a batch (measured)

static_assert(kBlockLanes == kQuad && kScanLanes == kFloats);

struct Beyond {
  unsigned sure, unsure;
};

inline Beyond compare_block(const Block& block, Vec3 v, Vec3 u) {
  const Quad x = (load_quad(block.x.data()) - v.x) * u.x;
  const Quad y = (load_quad(block.y.data()) - v.y) * u.y;
  const Quad z = (load_quad(block.z.data()) - v.z) * u.z;
  const Quad value = (x + y) + z;
  const Quad error = ((absolute_quad(x) + absolute_quad(y)) + absolute_quad(z)) * kDifferenceError + kUnderflow;
  return {quad_bits(value > error), quad_bits(absolute_quad(value) <= error)};
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

// A direction in floats. Where no float stands for it all vertices tie.
struct FloatDirection {
  float x, y, z;
  float tie;  // how much further along it one product has to be than another to be sure

  explicit FloatDirection(Vec3 u) {
    double length = norm_max(u), scale = 1;
    if (!(length > kSmallestFloat && length < kLargestFloat)) {
      scale = length > kSmallestDirection && length < kLargestDirection ? 1 / length : 0;
      length = 1;
    }
    x = static_cast<float>(u.x * scale), y = static_cast<float>(u.y * scale), z = static_cast<float>(u.z * scale);
    tie = kFloatTie * static_cast<float>(length);
  }

  Floats along(const ScanBlock& block) const {
    return (load_floats(block.x.data()) * x + load_floats(block.y.data()) * y) + load_floats(block.z.data()) * z;
  }
};

// The vertex of the blocks that is furthest along u; `vertex` says which one a lane is, `further` whether one is
// further than another.
template <class Vertex, class Further>
std::int32_t scanned(const std::vector<ScanBlock>& scan, Vec3 u, Vertex vertex, Further further,
                     QueryCounters& counters) {
  const FloatDirection direction(u);
  const std::size_t blocks = scan.size();
  std::array<Floats, kScannedVertices / kScanLanes + kBatch> values;
  std::array<Floats, kScannedVertices / kScanLanes / kBatch + 1> most;  // of a batch, lane by lane
  const Floats never = Floats{} - __builtin_inff();
  Floats best = never;
  std::size_t i = 0, batches = 0;
  if (blocks > kFewBlocks) {
    for (; i + kBatch <= blocks; i += kBatch) {
      const ScanBlock* const block = &scan[i];
      Floats* const out = &values[i];
      for (std::size_t k = 0; k < kBatch; ++k) out[k] = direction.along(block[k]);
      const Floats low = out[0] > out[1] ? out[0] : out[1], high = out[2] > out[3] ? out[2] : out[3];
      most[batches] = low > high ? low : high;
      best = most[batches] > best ? most[batches] : best;
      ++batches;
    }
  }
  for (; i < blocks; ++i) {
    values[i] = direction.along(scan[i]);
    best = values[i] > best ? values[i] : best;
  }
  counters.blocks += static_cast<long>(blocks * (kScanLanes / kBlockLanes));
  for (std::size_t k = 0; k < kBatch; ++k) values[blocks + k] = never;
  const Floats ties = Floats{} + (largest(best) - direction.tie);
  std::int32_t found = -1;
  const auto collect = [&](std::size_t first) {
    for (std::size_t k = first; k < first + kBatch; ++k) {
      for (unsigned left = float_bits(values[k] >= ties); left != 0; left &= left - 1) {
        const std::int32_t v = vertex(k * kScanLanes + static_cast<std::size_t>(__builtin_ctz(left)));
        if (found < 0 || (found != v && further(v, found))) found = v;
      }
    }
  };
  for (std::size_t b = 0; b < batches; ++b) {
    if (float_bits(most[b] >= ties) != 0) collect(b * kBatch);
  }
  for (i = batches * kBatch; i < blocks; i += kBatch) {
    FloatMask any = values[i] >= ties;
    for (std::size_t k = 1; k < kBatch; ++k) any |= values[i + k] >= ties;
    if (float_bits(any) != 0) collect(i);
  }
  return found < 0 ? vertex(0) : found;
}

}  // namespace

// Below the top, next_beyond needs a vertex that is truly extreme; where nothing follows, rounded products do.
std::int32_t extreme_at_top(const Levels& h, Vec3 u, QueryCounters& counters) {
  const auto vertex = [&](std::size_t i) { return h.top[i]; };
  const auto further = [&](std::int32_t v, std::int32_t than) {
    const Vec3 a = h.points[at(v)], b = h.points[at(than)];
    return h.depth > 0 ? compare_along(u, a, b) > 0 : dot(u, a) > dot(u, b);
  };
  return scanned(h.top_blocks, u, vertex, further, counters);
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
  if (!h.all_blocks.empty()) {
    const std::size_t last = h.points.size() - 1;
    const auto vertex = [&](std::size_t i) { return static_cast<std::int32_t>(i < last ? i : last); };
    const auto further = [&](std::int32_t v, std::int32_t than) {
      return compare_along(u, h.points[at(v)], h.points[at(than)]) > 0;
    };
    return scanned(h.all_blocks, u, vertex, further, counters);
  }
  return descend(h, extreme_at_top(h, u, counters), u, counters);
}

std::int32_t extreme_from(const Levels& h, std::int32_t v, Vec3 u, QueryCounters& counters) {
  for (std::int32_t coarser = v; coarser >= 0; coarser = beyond_in_ring(h, v, u, counters)) v = coarser;
  if (h.level[at(v)] == h.depth) v = extreme_at_top(h, u, counters);
  return descend(h, v, u, counters);
}

}  // namespace plannercheck
