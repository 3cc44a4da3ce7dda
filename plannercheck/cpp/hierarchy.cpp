#include "hierarchy.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>

#include "predicates.hpp"
#include "triangulation.hpp"
#include "wedges.hpp"

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

// Peels levels off until at most kTopVertices are left; `removals` is in the order of removal, fine to coarse.
std::vector<Removal> peel(Triangulation& mesh, std::vector<std::int32_t>& alive, std::int32_t* depth) {
  std::vector<Removal> removals;
  std::vector<std::int32_t> blocked(alive.size(), -1);
  *depth = 0;
  while (alive.size() > static_cast<std::size_t>(kTopVertices)) {
    const std::int32_t level = *depth;
    for (const std::int32_t v : removable_by_degree(mesh, alive)) {
      if (blocked[at(v)] == level) continue;
      Removal removal{v, level, mesh.ring(v)};
      for (const std::int32_t n : removal.ring) blocked[at(n)] = level;
      mesh.remove(v, removal.ring);
      removals.push_back(std::move(removal));
    }
    std::erase_if(alive, [&](std::int32_t v) { return !mesh.contains(v); });
    ++*depth;
  }
  return removals;
}

void lay_out_rings(const std::vector<Removal>& removals, Hierarchy& h) {
  const std::size_t n = h.points.size();
  h.ring_start.assign(n + 1, 0);
  for (const Removal& r : removals) h.ring_start[at(r.vertex) + 1] = static_cast<std::int32_t>(r.ring.size());
  for (std::size_t v = 0; v < n; ++v) h.ring_start[v + 1] += h.ring_start[v];
  h.rings.resize(at(h.ring_start[n]));
  for (const Removal& r : removals) {
    std::copy(r.ring.begin(), r.ring.end(), h.rings.begin() + h.ring_start[at(r.vertex)]);
  }
}

void lay_out_top(const std::vector<std::int32_t>& alive, Hierarchy& h) {
  h.top = alive;
  while (h.top.size() % kBlockLanes != 0) h.top.push_back(h.top.back());
  for (const std::int32_t v : h.top) {
    h.top_x.push_back(h.points[at(v)].x);
    h.top_y.push_back(h.points[at(v)].y);
    h.top_z.push_back(h.points[at(v)].z);
  }
}

void put(Hierarchy& h, const ChainRange& chain, std::int32_t position, std::int32_t vertex) {
  Block& block = h.blocks[at(chain.first_block + position / kBlockLanes)];
  const Vec3 p = h.points[at(vertex)];
  for (std::int32_t lane = position % kBlockLanes; lane < kBlockLanes; ++lane) {
    block.x[at(lane)] = p.x;
    block.y[at(lane)] = p.y;
    block.z[at(lane)] = p.z;
    block.vertex[at(lane)] = vertex;
  }
}

void lay_out_chains(const std::vector<Removal>& removals, Hierarchy& h) {
  h.chains.assign(h.points.size(), {});
  for (const Removal& r : removals) {
    for (const std::int32_t n : r.ring) ++h.chains[at(n)].length;
  }
  std::int32_t blocks = 0;
  for (ChainRange& chain : h.chains) {
    chain.first_block = blocks;
    blocks += (chain.length + kBlockLanes - 1) / kBlockLanes;
  }
  h.blocks.resize(at(blocks));
  std::vector<std::int32_t> filled(h.points.size(), 0);
  for (auto r = removals.rbegin(); r != removals.rend(); ++r) {
    for (const std::int32_t n : r->ring) put(h, h.chains[at(n)], filled[at(n)]++, r->vertex);
  }
}

}  // namespace

Hierarchy lay_out(const std::vector<Vec3>& points, const std::vector<Removal>& removals,
                  const std::vector<std::int32_t>& top, std::int32_t depth) {
  Hierarchy h;
  h.points = points;
  h.depth = depth;
  for (const Vec3& p : h.points) h.largest_coordinate = larger(h.largest_coordinate, norm_max(p));
  h.level.assign(points.size(), depth);
  for (const Removal& r : removals) h.level[at(r.vertex)] = r.level;
  h.fan_of.assign(points.size(), -1);
  lay_out_rings(removals, h);
  lay_out_top(top, h);
  lay_out_chains(removals, h);
  return h;
}

Hierarchy build_hierarchy(const ConvexMesh& mesh) {
  Triangulation current(mesh);
  std::vector<std::int32_t> alive(mesh.vertices.size());
  for (std::size_t v = 0; v < alive.size(); ++v) alive[v] = static_cast<std::int32_t>(v);
  std::int32_t depth = 0;
  const std::vector<Removal> removals = peel(current, alive, &depth);
  Hierarchy h = lay_out(mesh.vertices, removals, alive, depth);
  build_wedges(mesh, current, h);
  return h;
}

std::size_t Hierarchy::bytes() const {
  const auto size = [](const auto& v) { return v.size() * sizeof(v[0]); };
  return size(points) + size(level) + size(ring_start) + size(rings) + size(top) + size(top_x) * 3 + size(chains) +
         size(blocks) + size(fan_of) + size(fans) + size(wedges) + size(entries);
}

std::string hierarchy_fault(const ConvexMesh& mesh, const Hierarchy& h) {
  Triangulation current(mesh);
  std::vector<std::vector<std::int32_t>> by_level(at(h.depth));
  for (std::size_t v = 0; v < h.level.size(); ++v) {
    if (h.level[v] < h.depth) by_level[at(h.level[v])].push_back(static_cast<std::int32_t>(v));
  }
  std::vector<std::vector<std::int32_t>> chains(h.points.size());
  for (const auto& removed : by_level) {
    if (removed.empty()) return "a level removes nothing";
    for (const std::int32_t v : removed) {
      const std::string name = "vertex " + std::to_string(v);
      const std::vector<std::int32_t> ring = current.ring(v);
      if (ring.size() > kRemovedDegree) return name + " is removed with degree " + std::to_string(ring.size());
      std::vector<std::int32_t> stored(h.rings.begin() + h.ring_start[at(v)],
                                       h.rings.begin() + h.ring_start[at(v) + 1]);
      if (stored.size() != ring.size()) return name + " has a ring of the wrong length";
      std::rotate(stored.begin(), std::find(stored.begin(), stored.end(), ring.front()), stored.end());
      if (stored != ring) return name + " has a wrong ring";
      for (const std::int32_t n : ring) {
        if (h.level[at(n)] == h.level[at(v)]) return name + " is removed together with its neighbour";
        chains[at(n)].push_back(v);
      }
    }
    for (const std::int32_t v : removed) current.remove(v, current.ring(v));
    if (!current.is_convex()) return "a level is not convex";
  }
  for (std::size_t v = 0; v < chains.size(); ++v) {
    const ChainRange chain = h.chains[v];
    if (at(chain.length) != chains[v].size()) return "a chain is incomplete at vertex " + std::to_string(v);
    std::vector<std::int32_t> stored;
    for (std::int32_t i = 0; i < chain.length; ++i) {
      const Block& block = h.blocks[at(chain.first_block + i / kBlockLanes)];
      const auto lane = at(i % kBlockLanes);
      const std::int32_t child = block.vertex[lane];
      if (!(h.points[at(child)] == Vec3{block.x[lane], block.y[lane], block.z[lane]}))
        return "a chain's coordinates differ";
      if (!stored.empty() && h.level[at(stored.back())] < h.level[at(child)]) return "a chain is out of order";
      stored.push_back(child);
    }
    std::sort(stored.begin(), stored.end());
    std::sort(chains[v].begin(), chains[v].end());
    if (stored != chains[v]) return "a chain holds the wrong vertices at vertex " + std::to_string(v);
  }
  return wedge_fault(mesh, h);
}

}  // namespace plannercheck
