#include "narrow_phase/support_scan.hpp"

#include <array>

#include "math/double4.hpp"
#include "math/predicates.hpp"
#include "math/simd.hpp"

namespace plannercheck {
namespace {

// Entries are at most 1. Rounding direction and coordinates to floats errs by 2^-24 each, and so do products; two sums
// of at most 3 add 5 · 2^-24. So a product errs by at most 14 · 2^-24 times the direction's largest entry, underflow
// included. Vertices further below the highest than twice that are not extreme; their difference errs by 3 · 2^-24.
constexpr float kFloatTie = 32 * 0x1p-24F;
constexpr double kSmallestFloat = 1e-20, kLargestFloat = 1e20;  // of that entry; outside, the direction is scaled
constexpr double kSmallestDirection = 1e-290, kLargestDirection = 1e290;

static_assert(kScanLanes == kFloats);

// A direction in floats. All vertices tie where floats cannot represent it.
struct FloatDirection {
  float x, y, z;
  float tie;  // how much further along it a product has to be to be surely larger

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

// The furthest vertex among the lanes that are not much below the highest.
template <class Vertex, class Further>
void take_furthest(unsigned lanes, Vertex vertex, Further further, std::int32_t* found) {
  for (; lanes != 0; lanes &= lanes - 1) {
    const std::int32_t v = vertex(static_cast<std::size_t>(__builtin_ctz(lanes)));
    if (*found < 0 || (*found != v && further(v, *found))) *found = v;
  }
}

// Blocks of a cell that are scanned together; mostly these are all, so that nothing is kept in memory.
struct ScannedGroup {
  std::array<const CellBlock*, kGroup> block;
  std::array<Floats, kGroup> value;

  void scan(const DirectionCells& cells, const BlockGroup& group, const FloatDirection& direction) {
#pragma GCC unroll 4
    for (std::size_t k = 0; k < kGroup; ++k) {
      block[k] = &cells.blocks[group[k]];
      value[k] = direction.along(*block[k]);
    }
  }

  Floats highest() const {
    const Floats a = value[0] > value[1] ? value[0] : value[1], b = value[2] > value[3] ? value[2] : value[3];
    return a > b ? a : b;
  }

  unsigned lanes_above(Floats ties) const {
    unsigned lanes = 0;
#pragma GCC unroll 4
    for (std::size_t k = 0; k < kGroup; ++k) lanes |= bits_at_most(ties, value[k]) << (k * kScanLanes);
    return lanes;
  }
};

// The furthest of the top vertices. `vertex` maps a place to its vertex, `further` compares two.
template <class Vertex, class Further>
[[gnu::always_inline]] inline std::int32_t scanned_top(const Levels& h, Vec3 u, Vertex vertex, Further further,
                                                       QueryCounters& counters) {
  const FloatDirection direction(u);
  const std::size_t blocks = h.top_blocks.size();
  std::array<Floats, kUnlayered / kScanLanes> values;
  Floats best = Floats{} - __builtin_inff();
  for (std::size_t i = 0; i < blocks; ++i) {
    values[i] = direction.along(h.top_blocks[i]);
    best = values[i] > best ? values[i] : best;
  }
  counters.blocks += static_cast<long>(blocks * (kScanLanes / kBlockLanes));
  const Floats ties = Floats{} + (largest(best) - direction.tie);
  std::int32_t found = -1;
  for (std::size_t i = 0; i < blocks; ++i) {
    const auto in_block = [&](std::size_t lane) { return vertex(i * kScanLanes + lane); };
    take_furthest(bits_at_most(ties, values[i]), in_block, further, &found);
  }
  return found < 0 ? vertex(0) : found;
}

// So few vertices are scanned faster in doubles than in floats with candidates after it.
constexpr std::size_t kFewCursors = 8;

std::int32_t extreme_of_few(const Levels& h, double x, double y, double z, QueryCounters& counters) {
  const std::size_t blocks = h.top_cursors.size();
  std::array<double, kFewCursors * kDouble4Lanes> values;  // of vectors, whose array would be filled first
  Double4 best = Double4{} - __builtin_inf();
  for (std::size_t i = 0; i < blocks; ++i) {
    const VertexBlock& p = h.top_cursors[i];
    const Double4 value = (x * load_double4(p.x.data()) + y * load_double4(p.y.data())) + z * load_double4(p.z.data());
    store_double4(&values[i * kDouble4Lanes], value);
    best = value > best ? value : best;
  }
  counters.blocks += static_cast<long>(blocks);
  std::uint64_t lanes = 0;
  const Double4 most = spread_largest(best);
  for (std::size_t i = 0; i < blocks; ++i)
    lanes |= std::uint64_t{double4_bits(load_double4(&values[i * kDouble4Lanes]) == most)} << (i * kDouble4Lanes);
  return h.top[lanes == 0 ? 0 : static_cast<std::size_t>(__builtin_ctzll(lanes))];
}

std::int32_t extreme_of_many(const Levels& h, double x, double y, double z, QueryCounters& counters) {
  const Vec3 u{x, y, z};
  const auto vertex = [&](std::size_t i) { return h.top[i]; };
  const auto further = [&](std::int32_t v, std::int32_t than) {
    return dot(u, h.points[at(v)]) > dot(u, h.points[at(than)]);
  };
  return scanned_top(h, u, vertex, further, counters);
}

// The furthest vertex of a cell's groups.
[[gnu::noinline]] std::int32_t furthest_of_groups(const Levels& h, const Cell& cell, Vec3 u, QueryCounters& counters) {
  const DirectionCells& cells = h.cells;
  const FloatDirection direction(u);
  const std::size_t count = 1 + cell.count;
  std::array<ScannedGroup, kMostCellGroups> groups;
  groups[0].scan(cells, cell.first, direction);
  Floats highest = groups[0].highest();
  for (std::size_t g = 1; g < count; ++g) {
    groups[g].scan(cells, cells.groups[cell.others + g - 1], direction);
    const Floats other = groups[g].highest();
    highest = other > highest ? other : highest;
  }
  counters.blocks += static_cast<long>(count * kGroup * (kScanLanes / kBlockLanes));
  const Floats ties = Floats{} + (largest(highest) - direction.tie);
  const auto further = [&](std::int32_t v, std::int32_t than) {
    return compare_along(u, h.points[at(v)], h.points[at(than)]) > 0;
  };
  std::int32_t found = -1;
  for (std::size_t g = 0; g < count; ++g) {
    const auto vertex = [&](std::size_t lane) { return groups[g].block[lane / kScanLanes]->vertex[lane % kScanLanes]; };
    take_furthest(groups[g].lanes_above(ties), vertex, further, &found);
  }
  return found < 0 ? cells.blocks[0].vertex[0] : found;
}

}  // namespace

// Mostly one group holds all blocks of the cell, and floats leave one vertex: all stays in registers then.
std::int32_t extreme_in_cell(const Levels& h, const Cell& cell, double x, double y, double z, QueryCounters& counters) {
  const Vec3 u{x, y, z};
  if (cell.count != 0) return furthest_of_groups(h, cell, u, counters);
  const CellBlock* const blocks = h.cells.blocks.data();
  const FloatDirection direction(u);
  ScannedGroup group;
  group.scan(h.cells, cell.first, direction);
  unsigned lanes = group.lanes_above(Floats{} + (largest(group.highest()) - direction.tie));
  if (lanes == 0) [[unlikely]]
    return furthest_of_groups(h, cell, u, counters);
  const auto vertex = [&] {
    const auto lane = static_cast<std::size_t>(__builtin_ctz(lanes));
    return blocks[cell.first[lane / kScanLanes]].vertex[lane % kScanLanes];
  };
  const std::int32_t found = vertex();
  while ((lanes &= lanes - 1) != 0) {  // blocks and lanes may be repeated
    if (vertex() != found) [[unlikely]]
      return furthest_of_groups(h, cell, u, counters);
  }
  counters.blocks += static_cast<long>(kGroup * (kScanLanes / kBlockLanes));
  return found;
}

SearchCursor cursor_at_top(const Levels& h, Vec3 u, QueryCounters& counters) {
  const auto point = [&](std::int32_t i) { return h.top_cursors[at(i) / kBlockLanes].point(at(i) % kBlockLanes); };
  const auto place = [](std::size_t i) { return static_cast<std::int32_t>(i); };
  const auto further = [&](std::int32_t i, std::int32_t than) { return compare_along(u, point(i), point(than)) > 0; };
  const std::size_t found = at(scanned_top(h, u, place, further, counters));
  return h.top_cursors[found / kBlockLanes].cursor(found % kBlockLanes);
}

std::int32_t extreme_of_top(const Levels& h, double x, double y, double z, QueryCounters& counters) {
  if (h.top_cursors.size() <= kFewCursors) return extreme_of_few(h, x, y, z, counters);
  return extreme_of_many(h, x, y, z, counters);
}

}  // namespace plannercheck
