#include "bodies/hierarchy.hpp"

#include <algorithm>
#include <string>

#include "bodies/triangulation.hpp"
#include "bodies/wedges.hpp"
#include "math/interruption.hpp"
#include "math/predicates.hpp"

namespace plannercheck {
namespace {

// Vertices of degree at most kRemovedDegree in ascending order of degree, by counting.
std::vector<std::int32_t> removable_by_degree(const Triangulation& mesh, const std::vector<std::int32_t>& alive) {
  std::array<std::vector<std::int32_t>, kRemovedDegree + 1> buckets;
  for (const std::int32_t v : alive) {
    if (mesh.degree(v) <= kRemovedDegree) buckets[at(mesh.degree(v))].push_back(v);
  }
  std::vector<std::int32_t> sorted;
  for (const auto& bucket : buckets) sorted.insert(sorted.end(), bucket.begin(), bucket.end());
  return sorted;
}

// Whether all vertices of a ring lie in a plane; no three of them are collinear.
bool coplanar(const std::vector<Vec3>& points, const std::vector<std::int32_t>& ring) {
  return std::all_of(ring.begin(), ring.end(), [&](std::int32_t n) {
    return orientation(points[at(ring[0])], points[at(ring[1])], points[at(ring[2])], points[at(n)]) == 0;
  });
}

// Removes levels until `most` vertices are left. The last level removes no more than that takes, so that bodies of all
// sizes have equal tops. An apex without which the rest would be flat stays. Removals come in order, fine to coarse.
std::vector<Removal> peel(Triangulation& mesh, std::vector<std::int32_t>& alive, std::size_t most,
                          std::int32_t* depth) {
  std::vector<Removal> removals;
  std::vector<std::int32_t> blocked(at(alive.back()) + 1, -1);
  *depth = 0;
  while (alive.size() > most) {
    const std::int32_t level = *depth;
    std::size_t left = alive.size();
    for (const std::int32_t v : removable_by_degree(mesh, alive)) {
      poll_interruption();
      if (left == most) break;
      if (blocked[at(v)] == level) continue;
      Removal removal{v, level, mesh.ring(v)};
      if (removal.ring.size() + 1 == left && coplanar(mesh.points(), removal.ring)) continue;
      for (const std::int32_t n : removal.ring) blocked[at(n)] = level;
      mesh.remove(v, removal.ring);
      removals.push_back(std::move(removal));
      --left;
    }
    std::erase_if(alive, [&](std::int32_t v) { return !mesh.contains(v); });
    ++*depth;
  }
  return removals;
}

void lay_out_rings(const std::vector<Removal>& removals, Levels& h) {
  const std::size_t n = h.points.size();
  h.ring_start.assign(n + 1, 0);
  for (const Removal& r : removals) h.ring_start[at(r.vertex) + 1] = static_cast<std::int32_t>(r.ring.size());
  for (std::size_t v = 0; v < n; ++v) h.ring_start[v + 1] += h.ring_start[v];
  h.rings.resize(at(h.ring_start[n]));
  for (const Removal& r : removals) {
    std::copy(r.ring.begin(), r.ring.end(), h.rings.begin() + h.ring_start[at(r.vertex)]);
  }
}

void lay_out_scans(const std::vector<std::int32_t>& alive, Levels& h) {
  h.top = alive;
  while (h.top.size() % kScanLanes != 0) h.top.push_back(h.top.back());
  h.top_blocks.resize(h.top.size() / kScanLanes);
  const double unit = h.largest_coordinate > 0 ? h.largest_coordinate : 1;
  for (std::size_t i = 0; i < h.top.size(); ++i) {
    h.top_blocks[i / kScanLanes].put(i % kScanLanes, h.points[at(h.top[i])], unit);
  }
  if (h.points.size() <= at(kUnlayered) || h.points.size() > kMostCellVertices) return;
  h.cells = direction_cells(h.points, h.largest_coordinate);
}

void put(const Levels& h, VertexBlock& block, std::int32_t first_lane, std::int32_t vertex) {
  const Vec3 p = h.points[at(vertex)];
  for (std::int32_t lane = first_lane; lane < kBlockLanes; ++lane) {
    block.x[at(lane)] = p.x;
    block.y[at(lane)] = p.y;
    block.z[at(lane)] = p.z;
    block.vertex[at(lane)] = vertex;
    block.chain[at(lane)] = kNoChain;
  }
}

// Vertices from the coarsest level to the finest, ascending within a level.
std::vector<std::int32_t> coarse_first(const Levels& h) {
  std::vector<std::int32_t> order = indices_below(h.points.size());
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t v, std::int32_t w) { return h.level[at(v)] > h.level[at(w)]; });
  return order;
}

void lay_out_chains(const std::vector<Removal>& removals, Levels& h) {
  h.chains.assign(h.points.size(), {});
  for (const Removal& r : removals) {
    for (const std::int32_t n : r.ring) ++h.chains[at(n)].length;
  }
  std::int32_t blocks = 0;
  for (const std::int32_t v : coarse_first(h)) {
    ChainRange& chain = h.chains[at(v)];
    chain.first_block = blocks;
    blocks += (chain.length + kBlockLanes - 1) / kBlockLanes;
  }
  h.blocks.resize(at(blocks));
  std::vector<std::int32_t> filled(h.points.size(), 0);
  for (auto r = removals.rbegin(); r != removals.rend(); ++r) {
    for (const std::int32_t n : r->ring) {
      const std::int32_t position = filled[at(n)]++;
      put(h, h.blocks[at(h.chains[at(n)].first_block + position / kBlockLanes)], position % kBlockLanes, r->vertex);
    }
  }
  for (const ChainRange& chain : h.chains) {
    if (chain.length == 0) continue;
    for (std::int32_t& v : h.blocks[at(chain.first_block + (chain.length - 1) / kBlockLanes)].vertex) v = ~v;
  }
}

void lay_out_top_cursors(Levels& h) {
  h.top_cursors.resize(h.top.size() / kBlockLanes);
  for (std::size_t i = 0; i < h.top.size(); ++i) {
    put(h, h.top_cursors[i / kBlockLanes], static_cast<std::int32_t>(i % kBlockLanes), h.top[i]);
  }
}

}  // namespace

void link_chains(Levels& h) {
  const auto link = [&](VertexBlock& block) {
    for (std::size_t lane = 0; lane < kBlockLanes; ++lane) block.chain[lane] = h.chain_of(block.id(lane));
  };
  std::for_each(h.blocks.begin(), h.blocks.end(), link);
  std::for_each(h.top_cursors.begin(), h.top_cursors.end(), link);
}

Levels lay_out(const std::vector<Vec3>& points, const std::vector<Removal>& removals,
               const std::vector<std::int32_t>& top, std::int32_t depth) {
  Levels h;
  h.points = points;
  h.depth = depth;
  for (const Vec3& p : h.points) h.largest_coordinate = larger(h.largest_coordinate, norm_max(p));
  h.level.assign(points.size(), depth);
  for (const Removal& r : removals) h.level[at(r.vertex)] = r.level;
  h.fan_of.assign(points.size(), -1);
  lay_out_rings(removals, h);
  lay_out_scans(top, h);
  lay_out_chains(removals, h);
  lay_out_top_cursors(h);
  link_chains(h);
  return h;
}

Levels lay_out_top_levels(const Levels& levels, std::vector<Removal> removals, std::vector<std::int32_t> stay,
                          std::int32_t depth) {
  std::vector<Vec3> points;
  std::vector<std::int32_t> position(levels.points.size(), -1);
  for (const std::int32_t v : levels.top) {
    if (position[at(v)] >= 0) continue;
    position[at(v)] = static_cast<std::int32_t>(points.size());
    points.push_back(levels.points[at(v)]);
  }
  for (std::int32_t& v : stay) v = position[at(v)];
  for (Removal& r : removals) {
    r.vertex = position[at(r.vertex)];
    for (std::int32_t& n : r.ring) n = position[at(n)];
  }
  return lay_out(points, removals, stay, depth);
}

Hierarchy build_hierarchy(const ConvexMesh& mesh) {
  Triangulation current(mesh);
  std::vector<std::int32_t> alive = indices_below(mesh.vertices.size());
  const std::size_t top = at(alive.size() > at(kUnlayered) ? kTopVertices : kUnlayered);
  std::int32_t depth = 0;
  const std::vector<Removal> removals = peel(current, alive, top, &depth);
  Hierarchy h{lay_out(mesh.vertices, removals, alive, depth), {}};
  build_wedges(mesh, current, h);
  const std::vector<Removal> further = peel(current, alive, at(kHighestTop), &depth);
  h.top_levels = lay_out_top_levels(h, further, alive, depth);
  return h;
}

std::size_t Levels::bytes() const {
  const auto size = [](const auto& v) { return v.size() * sizeof(v[0]); };
  return size(points) + size(level) + size(ring_start) + size(rings) + size(top) + size(top_blocks) +
         size(top_cursors) + cells.bytes() + size(chains) + size(blocks) + size(fan_of) + size(fans) + size(wedges) +
         size(entries);
}

namespace {

// Checks the levels by removing them from `current`, whose vertex ids[i] is vertex i of the levels.
std::string levels_fault(Triangulation& current, const std::vector<std::int32_t>& ids, const Levels& h) {
  std::vector<std::vector<std::int32_t>> by_level(at(h.depth));
  for (std::size_t v = 0; v < h.level.size(); ++v) {
    if (h.level[v] < h.depth) by_level[at(h.level[v])].push_back(static_cast<std::int32_t>(v));
  }
  std::vector<std::vector<std::int32_t>> chains(h.points.size());
  for (const auto& removed : by_level) {
    if (removed.empty()) return "a level removes nothing";
    for (const std::int32_t v : removed) {
      const std::string name = "vertex " + std::to_string(v);
      const std::vector<std::int32_t> ring = current.ring(ids[at(v)]);
      if (ring.size() > kRemovedDegree) return name + " is removed with degree " + std::to_string(ring.size());
      const std::vector<std::int32_t> own(h.rings.begin() + h.ring_start[at(v)],
                                          h.rings.begin() + h.ring_start[at(v) + 1]);
      std::vector<std::int32_t> stored;
      for (const std::int32_t n : own) stored.push_back(ids[at(n)]);
      if (stored.size() != ring.size()) return name + " has a ring of the wrong length";
      std::rotate(stored.begin(), std::find(stored.begin(), stored.end(), ring.front()), stored.end());
      if (stored != ring) return name + " has a wrong ring";
      for (const std::int32_t n : own) {
        if (h.level[at(n)] == h.level[at(v)]) return name + " is removed together with its neighbour";
        chains[at(n)].push_back(v);
      }
    }
    for (const std::int32_t v : removed) current.remove(ids[at(v)], current.ring(ids[at(v)]));
    if (!current.is_convex()) return "a level is not convex";
  }
  for (std::size_t v = 0; v < chains.size(); ++v) {
    const ChainRange chain = h.chains[v];
    if (at(chain.length) != chains[v].size()) return "a chain is incomplete at vertex " + std::to_string(v);
    std::vector<std::int32_t> stored;
    for (std::int32_t i = 0; i < chain.length; ++i) {
      const VertexBlock& block = h.blocks[at(chain.first_block + i / kBlockLanes)];
      const auto lane = at(i % kBlockLanes);
      const std::int32_t child = block.id(lane);
      if (!(h.points[at(child)] == block.point(lane))) return "a chain's coordinates differ";
      if (block.chain[lane] != h.chain_of(child)) return "a chain leads astray";
      if (block.is_last() != (i / kBlockLanes == (chain.length - 1) / kBlockLanes)) return "a chain ends elsewhere";
      if (!stored.empty() && h.level[at(stored.back())] < h.level[at(child)]) return "a chain is out of order";
      stored.push_back(child);
    }
    std::sort(stored.begin(), stored.end());
    std::sort(chains[v].begin(), chains[v].end());
    if (stored != chains[v]) return "a chain holds the wrong vertices at vertex " + std::to_string(v);
  }
  return {};
}

}  // namespace

std::string hierarchy_fault(const ConvexMesh& mesh, const Hierarchy& h) {
  Triangulation current(mesh);
  const std::string main = levels_fault(current, indices_below(h.points.size()), h);
  if (!main.empty()) return main;
  const std::string top_levels = levels_fault(current, h.top, h.top_levels);
  if (!top_levels.empty()) return "top levels: " + top_levels;
  for (std::size_t i = 0; i < h.top_levels.points.size(); ++i) {
    if (!(h.top_levels.points[i] == h.points[at(h.top[i])])) return "the top levels' coordinates differ";
  }
  return wedge_fault(mesh, h);
}

}  // namespace plannercheck
