// Bodies as bytes: the fields in order, each array after its length, in the machine's byte order. What is read is
// checked for everything that queries rely on before any query runs.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "bodies/polytope.hpp"

namespace plannercheck {
namespace {

class Writer {
 public:
  template <class T>
  void value(const T& v) {
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  template <class T>
  void array(const T& v) {
    value(static_cast<std::uint64_t>(v.size()));
    bytes_.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(v[0]));
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(const char* data, std::size_t size) : data_(data), left_(size) {}
  template <class T>
  void value(T& v) {
    take(&v, sizeof v);
  }
  template <class T>
  void array(T& v) {
    std::uint64_t count = 0;
    value(count);
    if (count > left_ / sizeof(v[0])) throw HullError("the data end early");
    v.resize(count);
    take(v.data(), count * sizeof(v[0]));
  }
  bool done() const { return left_ == 0; }

 private:
  const char* data_;
  std::size_t left_;

  void take(void* to, std::size_t size) {
    if (size > left_) throw HullError("the data end early");
    if (size > 0) std::memcpy(to, data_, size);
    data_ += size;
    left_ -= size;
  }
};

// The fields in the order of the format, for both reading and writing.
template <class Stream, class H>
void each_level_field(Stream& s, H& h) {
  s.array(h.points), s.array(h.level), s.value(h.depth), s.array(h.ring_start), s.array(h.rings), s.array(h.top);
  s.array(h.top_blocks), s.array(h.top_cursors), s.value(h.cells.edge), s.array(h.cells.cells), s.array(h.cells.groups),
      s.array(h.cells.blocks), s.array(h.chains), s.array(h.blocks);
  s.array(h.fan_of), s.array(h.fans), s.array(h.wedges), s.array(h.entries), s.value(h.largest_coordinate);
}

template <class Stream, class H>
void each_field(Stream& s, H& h) {
  each_level_field(s, h);
  each_level_field(s, h.top_levels);
}

template <class Stream, class B>
void each_polytope_field(Stream& s, B& b) {
  s.value(b.dimension), s.value(b.inflation_radius), s.array(b.triangles), s.array(b.source), s.value(b.centre),
      s.value(b.origin_radius), s.value(b.radius), s.value(b.low), s.value(b.high), s.value(b.is_box);
  each_field(s, b.inner);
  each_field(s, b.polar);
  s.array(b.polar_triangles);
  s.value(b.polar_radius), s.value(b.facet_count);
}

void require(bool sound) {
  if (!sound) throw HullError("the data are damaged");
}

bool is_finite(Vec3 p) { return std::isfinite(norm_1(p)); }

bool is_length(double length) { return length >= 0 && std::isfinite(length); }

bool is_below(std::int32_t index, std::size_t end) { return index >= 0 && at(index) < end; }

bool is_below_or_none(std::int32_t index, std::size_t end) { return index == -1 || is_below(index, end); }

bool all_below(const std::vector<std::int32_t>& indices, std::size_t end) {
  return std::all_of(indices.begin(), indices.end(), [&](std::int32_t i) { return is_below(i, end); });
}

bool all_corners_below(const std::vector<Triangle>& triangles, std::size_t end) {
  return std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](int i) { return is_below(i, end); });
  });
}

bool within(std::int32_t first, std::int32_t count, std::size_t end) {
  return first >= 0 && count >= 0 && at(first) + at(count) <= end;
}

void require_sound_wedge(const Levels& h, std::size_t w) {
  const WedgeNode& node = h.wedges[w];
  const std::size_t n = h.points.size();
  require(is_below(node.rim, n) && is_below_or_none(node.left, n) && is_below_or_none(node.right, n));
  for (const std::int32_t next : {node.next_left, node.next, node.next_right}) {
    require(is_below_or_none(next, h.wedges.size()) && (next < 0 || at(next) > w));
  }
  require((node.left < 0) == (node.next_left < 0) && (node.right < 0) == (node.next_right < 0));
  require(node.next >= 0 || node.left >= 0 || node.right < 0);
}

// No cell has too many groups, and groups name only existing blocks.
void require_sound_cells(const DirectionCells& c, std::size_t vertices) {
  constexpr std::int32_t kMostEdge = 1 << 10;
  require(c.edge >= 0 && c.edge <= kMostEdge);
  require(c.cells.size() == 6 * at(c.edge) * at(c.edge));
  const auto is_sound = [&](const BlockGroup& group) {
    return std::all_of(group.begin(), group.end(), [&](std::uint16_t block) { return block < c.blocks.size(); });
  };
  for (const Cell& cell : c.cells) {
    require(is_sound(cell.first) && cell.count < kMostCellGroups && cell.others <= c.groups.size());
    require(cell.count <= c.groups.size() - cell.others);
  }
  require(std::all_of(c.groups.begin(), c.groups.end(), is_sound));
  for (const CellBlock& block : c.blocks) {
    for (const std::int32_t v : block.vertex) require(is_below(v, vertices));
  }
}

// Blocks repeat the vertex data that descents need.
void require_sound_block(const Levels& h, const VertexBlock& block) {
  for (std::size_t lane = 0; lane < kBlockLanes; ++lane) {
    const SearchCursor cursor = block.cursor(lane);
    require(is_below(cursor.vertex, h.points.size()));
    const SearchCursor meant = h.cursor(cursor.vertex);
    require(cursor.chain == meant.chain && cursor.point == meant.point);
  }
}

bool is_marked(const VertexBlock& block, bool last) {
  return std::all_of(block.vertex.begin(), block.vertex.end(), [&](std::int32_t v) { return (v < 0) == last; });
}

// Chains share no blocks, so their lengths add up to the number of blocks; a scan ends at the mark of its last block.
void require_sound_chains(const Levels& h) {
  std::size_t chained = 0;
  for (const ChainRange& chain : h.chains) {
    require(chain.length >= 0);
    const std::int32_t count = chain.length / kBlockLanes + (chain.length % kBlockLanes != 0);
    chained += at(count);
    require(chained <= h.blocks.size() && within(chain.first_block, count, h.blocks.size()));
    for (std::int32_t k = 0; k < count; ++k) {
      require(is_marked(h.blocks[at(chain.first_block + k)], k + 1 == count));
    }
  }
  require(chained == h.blocks.size());
}

// Per wedge: the lowest level among the vertices whose walks come to it.
std::vector<std::int32_t> levels_of_walks(const Levels& h) {
  std::vector<std::int32_t> lowest(h.wedges.size(), std::numeric_limits<std::int32_t>::max());
  const auto lower = [&](std::int32_t wedge, std::int32_t level) {
    if (wedge >= 0) lowest[at(wedge)] = std::min(lowest[at(wedge)], level);
  };
  for (std::size_t v = 0; v < h.points.size(); ++v) {
    if (h.fan_of[v] < 0) continue;
    const WedgeFan& fan = h.fans[at(h.fan_of[v])];
    for (std::int32_t i = 0; i < fan.entries; ++i) lower(h.entries[at(fan.first_entry + i)], h.level[v]);
  }
  for (std::size_t w = 0; w < h.wedges.size(); ++w) {
    for (const std::int32_t next : {h.wedges[w].next_left, h.wedges[w].next, h.wedges[w].next_right}) {
      lower(next, lowest[w]);
    }
  }
  return lowest;
}

// Chains and wedges lead to finer levels only, else the coupled walk would not end; its games hold few vertices.
void require_falling_levels(const Levels& h) {
  for (std::size_t v = 0; v < h.points.size(); ++v) {
    const std::int32_t degree = h.ring_start[v + 1] - h.ring_start[v], level = h.level[v];
    require(level >= 0 && level <= h.depth && degree <= (level < h.depth ? kRemovedDegree : 0));
    for (std::int32_t i = 0; i < h.chains[v].length; ++i) {
      const VertexBlock& block = h.blocks[at(h.chains[v].first_block + i / kBlockLanes)];
      require(h.level[at(block.id(at(i % kBlockLanes)))] < level);
    }
  }
  const std::vector<std::int32_t> lowest = levels_of_walks(h);
  for (std::size_t w = 0; w < h.wedges.size(); ++w) {
    for (const std::int32_t child : {h.wedges[w].left, h.wedges[w].right}) {
      require(child < 0 || h.level[at(child)] < lowest[w]);
    }
  }
}

// The top holds the vertices that no level removes, each once except for padding at the end. Returns how many.
std::size_t require_sound_top(const Levels& h) {
  const auto staying = at(static_cast<std::int32_t>(std::count(h.level.begin(), h.level.end(), h.depth)));
  require(staying >= 1 && staying <= h.top.size());
  for (std::size_t i = 0; i < h.top.size(); ++i) {
    require(h.level[at(h.top[i])] == h.depth &&
            (i == 0 || (i < staying ? h.top[i - 1] < h.top[i] : h.top[i - 1] == h.top[i])));
  }
  return staying;
}

// Every index that a query follows stays in its array, and wedges lead on to later ones only. So damaged data may give
// wrong answers, but no query leaves its memory or runs forever.
void require_sound_levels(const Levels& h) {
  const std::size_t n = h.points.size(), top = h.top.size();
  for (const Vec3& p : h.points) require(is_finite(p));
  require(n >= 1 && h.level.size() == n && h.chains.size() == n && h.fan_of.size() == n && h.depth >= 0);
  require(h.ring_start.size() == n + 1 && h.ring_start.front() == 0 && at(h.ring_start.back()) == h.rings.size());
  require(std::is_sorted(h.ring_start.begin(), h.ring_start.end()) && all_below(h.rings, n));
  require(top > 0 && top <= kUnlayered && top == h.top_blocks.size() * kScanLanes && all_below(h.top, n));
  require_sound_top(h);
  require_sound_cells(h.cells, n);
  require_sound_chains(h);
  for (const std::int32_t fan : h.fan_of) require(is_below_or_none(fan, h.fans.size()));
  for (const VertexBlock& block : h.blocks) require_sound_block(h, block);
  for (const VertexBlock& block : h.top_cursors) require_sound_block(h, block);
  require(h.top_cursors.size() == top / kBlockLanes);
  require(!h.blocks.empty() || h.depth == 0);
  require(all_below(h.entries, h.wedges.size()));
  for (const WedgeFan& fan : h.fans) {
    require(fan.entries > 0 && within(fan.first_entry, fan.entries, h.entries.size()));
    require(fan.first_half >= 1 && fan.first_half <= fan.entries && is_finite(fan.axis));
  }
  for (std::size_t w = 0; w < h.wedges.size(); ++w) require_sound_wedge(h, w);
  require_falling_levels(h);
}

void require_sound_hierarchy(const Hierarchy& h) {
  require_sound_levels(h);
  require_sound_levels(h.top_levels);
  require(h.top_levels.points.size() == require_sound_top(h) && h.top_levels.top.size() <= at(kHighestTop));
  for (std::size_t i = 0; i < h.top_levels.points.size(); ++i)
    require(h.top_levels.points[i] == h.points[at(h.top[i])]);
}

void require_sound_measures(const Polytope& body) {
  require(body.dimension >= 0 && body.dimension <= 3 && is_length(body.inflation_radius) &&
          is_length(body.origin_radius) && is_length(body.radius) && body.polar_radius >= 0);
  require(is_finite(body.centre) && is_finite(body.low) && is_finite(body.high));
  require(body.is_box == 0 || (body.is_box == 1 && body.inner.points.size() == 8));
}

}  // namespace

std::string serialise(const Polytope& body) {
  Writer writer;
  each_polytope_field(writer, body);
  return writer.take();
}

Polytope parse_polytope(const char* data, std::size_t size) {
  Polytope body;
  Reader reader(data, size);
  each_polytope_field(reader, body);
  if (!reader.done()) throw HullError("the data go on after the end");
  require_sound_measures(body);
  require_sound_hierarchy(body.inner);
  if (body.has_polar()) require_sound_hierarchy(body.polar);
  require(body.source.size() == body.inner.points.size() &&
          all_corners_below(body.triangles, body.inner.points.size()));
  body.ellipsoid = equivalent_ellipsoid(body.inner.points, body.triangles);
  require(all_corners_below(body.polar_triangles, body.polar.points.size()));
  return body;
}

}  // namespace plannercheck
