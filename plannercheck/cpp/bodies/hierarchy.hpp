// The inner hierarchy of a convex body (Dobkin and Kirkpatrick 1985; properties A1 to A5 of the paper), and extreme
// vertices from it.
//
// In: the exact hull of a point set. Out: for each vertex the level at which it is removed and its neighbours there
// (its ring, at most kRemovedDegree); for queries the top vertices and, for each vertex, one chain: the neighbours
// removed around it, coarse to fine. The levels themselves need not exist at run time. If the plane through v with
// normal u is tangent at every level of the chain so far, at most one vertex of the next level lies beyond it, and it
// is a neighbour of v (Lemma "halfspace property").
//
// Vertices with long chains (a cone's apex, a fan's hub) are not scanned but walked by wedges; see WedgeNode.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bodies/direction_cells.hpp"
#include "bodies/hull.hpp"
#include "math/vec.hpp"

namespace plannercheck {

inline constexpr int kUnlayered = 64;     // up to this many all vertices are at the top
inline constexpr int kTopVertices = 48;   // left at the top of the hierarchies of larger bodies
inline constexpr int kHighestTop = 8;     // makes the coupled walk's first game as small as its later ones
inline constexpr int kRemovedDegree = 8;  // a planar graph has enough independent vertices of at most this degree
inline constexpr int kBlockLanes = 4;     // the same on every instruction set, so that files are, too
inline constexpr int kLongChain = 64;     // entries; longer chains are walked by wedges (16 blocks of scanning)

inline constexpr std::int32_t kNoChain = -1;

// The position of a descent: a vertex, and the data of it that the next step needs.
struct SearchCursor {
  Vec3 point;
  std::int32_t vertex = 0;
  // Its first block, or kNoChain if there is none, or a number below that: `fan_at` of a walk by wedges.
  std::int32_t chain = kNoChain;

  bool is_walked() const { return chain < kNoChain; }
  std::int32_t fan() const { return kNoChain - 1 - chain; }
  static std::int32_t fan_at(std::int32_t fan) { return kNoChain - 1 - fan; }
};

// Four neighbours in a chain with all data that a descent needs of them, so that its next step waits for memory once:
// two cache lines. Lanes after the chain's end repeat the last entry.
struct alignas(64) VertexBlock {
  std::array<double, kBlockLanes> x, y, z;
  std::array<std::int32_t, kBlockLanes> vertex;  // complements of the ids in a chain's last block
  std::array<std::int32_t, kBlockLanes> chain;   // as in SearchCursor

  bool is_last() const { return vertex[0] < 0; }
  std::int32_t id(std::size_t lane) const { return vertex[lane] < 0 ? ~vertex[lane] : vertex[lane]; }
  Vec3 point(std::size_t lane) const { return {x[lane], y[lane], z[lane]}; }
  SearchCursor cursor(std::size_t lane) const { return {point(lane), id(lane), chain[lane]}; }
};
static_assert(sizeof(VertexBlock) == 128);

struct ChainRange {
  std::int32_t first_block = 0, length = 0;  // length in entries
};

// The state (v, r) of wedge refinement: u lies in the wedge of v's normal cone spanned by z_v and the normals of the
// two facets along the edge v r. The node exists from the level where that edge and its facets appear to the level
// where one of these facets is lost to the hole of a removed vertex.
struct WedgeNode {
  std::int32_t rim = -1;               // r
  std::int32_t left = -1, right = -1;  // third vertices of the facets counter-clockwise of the edge and clockwise
  std::int32_t next_left = -1, next = -1, next_right = -1;  // nodes of (v, left), (v, r), (v, right) one level down
};

struct WedgeFan {
  Vec3 axis;  // z_v: strictly inside v's normal cone in the finest level, verified exactly
  std::int32_t first_entry = 0, entries = 0;  // nodes of v's edges at the level where v appears, counter-clockwise
  // How many entries follow, 1 to `entries`, until the normals of the facets clockwise of them have turned by half a
  // turn about z_v from the first one's. It is rounded, so a search has to verify what it finds by it.
  std::int32_t first_half = 1;
  std::int32_t padding = 0;  // files hold no undefined bytes
};

struct Levels {
  std::vector<Vec3> points;
  std::vector<std::int32_t> level;       // at which the vertex is removed; `depth` for those that stay
  std::int32_t depth = 0;                // number of removals; level 0 removes from the full body
  std::vector<std::int32_t> ring_start;  // rings in CSR form, counter-clockwise; empty for top vertices
  std::vector<std::int32_t> rings;
  std::vector<std::int32_t> top;  // ids, padded to whole blocks by repetition
  std::vector<ScanBlock> top_blocks;
  std::vector<VertexBlock> top_cursors;
  DirectionCells cells;  // of bodies that are scanned although they have levels
  std::vector<ChainRange> chains;
  std::vector<VertexBlock> blocks;   // chains of coarse vertices first, which keeps what most queries read together
  std::vector<std::int32_t> fan_of;  // per vertex: index into fans, or -1
  std::vector<WedgeFan> fans;
  std::vector<WedgeNode> wedges;
  std::vector<std::int32_t> entries;  // indices into wedges
  double largest_coordinate = 0;

  // Where a descent at v continues.
  std::int32_t chain_of(std::int32_t v) const {
    if (fan_of[at(v)] >= 0) return SearchCursor::fan_at(fan_of[at(v)]);
    return chains[at(v)].length > 0 ? chains[at(v)].first_block : kNoChain;
  }
  SearchCursor cursor(std::int32_t v) const { return {points[at(v)], v, chain_of(v)}; }

  std::size_t bytes() const;
};

// Searches for extreme vertices start at the top, where a scan is fastest. The coupled walk starts with a game of all
// vertices of a level, so it starts higher up, in the top levels: a hierarchy of the top vertices, whose vertex i is
// top[i].
struct Hierarchy : Levels {
  Levels top_levels;
};

Hierarchy build_hierarchy(const ConvexMesh& mesh);

struct Removal {
  std::int32_t vertex, level;
  std::vector<std::int32_t> ring;  // its neighbours when it is removed, counter-clockwise
};

// Levels without wedges. `removals`: in their order, fine to coarse; the vertices that stay are in ascending order.
Levels lay_out(const std::vector<Vec3>& points, const std::vector<Removal>& removals,
               const std::vector<std::int32_t>& top, std::int32_t depth);

// Leads each entry of a chain to that vertex's own chain; called again once fans are added.
void link_chains(Levels& levels);

// The top levels, from further removals: of top vertices, down to the vertices that stay.
Levels lay_out_top_levels(const Levels& levels, std::vector<Removal> removals, std::vector<std::int32_t> stay,
                          std::int32_t depth);

// Describes the first broken property of the hierarchy of this mesh, empty if there is none: levels nested, removed
// vertices independent and of bounded degree, every level convex, chains complete and in order, wedges consistent; the
// top levels likewise.
std::string hierarchy_fault(const ConvexMesh& mesh, const Hierarchy& hierarchy);

}  // namespace plannercheck
