#include "bodies/wedges.hpp"

#include <algorithm>

#include "math/interruption.hpp"
#include "math/predicates.hpp"

namespace plannercheck {
namespace {

// The ring of one vertex as its level gets finer: a cyclic list of neighbours, each with its current wedge.
struct Rim {
  std::vector<std::int32_t> next, previous, wedge;

  explicit Rim(std::size_t vertices) : next(vertices, -1), previous(vertices, -1), wedge(vertices, -1) {}

  void join(std::int32_t a, std::int32_t b) {
    next[at(a)] = b;
    previous[at(b)] = a;
  }
};

class WedgeBuilder {
 public:
  WedgeBuilder(const ConvexMesh& mesh, const Triangulation& coarsest, Levels& h)
      : finest_(mesh), coarsest_(coarsest), h_(h), rim_(mesh.vertices.size()) {}

  void build(std::int32_t v) {
    WedgeFan fan;
    if (!find_axis(v, &fan.axis)) return;
    const std::vector<std::int32_t> ring = first_ring(v);
    fan.first_entry = static_cast<std::int32_t>(h_.entries.size());
    fan.entries = static_cast<std::int32_t>(ring.size());
    for (std::size_t i = 0; i < ring.size(); ++i) {
      rim_.join(ring[i], ring[(i + 1) % ring.size()]);
      open(ring[i]);
      h_.entries.push_back(rim_.wedge[at(ring[i])]);
    }
    fan.first_half = first_half(v, ring, fan.axis);
    refine(v);
    h_.fan_of[at(v)] = static_cast<std::int32_t>(h_.fans.size());
    h_.fans.push_back(fan);
  }

 private:
  Triangulation finest_;
  const Triangulation& coarsest_;
  Levels& h_;
  Rim rim_;

  Vec3 point(std::int32_t v) const { return h_.points[at(v)]; }

  bool is_axis(std::int32_t v, const std::vector<std::int32_t>& ring, Vec3 z) const {
    return std::all_of(ring.begin(), ring.end(),
                       [&](std::int32_t n) { return compare_along(z, point(v), point(n)) > 0; });
  }

  // Tries the sum of the facets' unit normals and that of their area normals. Both may fail at a nearly flat vertex,
  // whose cone is thinner than the grid of doubles; its chain is then scanned, which is slower but as right.
  bool find_axis(std::int32_t v, Vec3* axis) const {
    const std::vector<std::int32_t> ring = finest_.ring(v);
    Vec3 units, areas;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec3 n = cross(point(ring[i]) - point(v), point(ring[(i + 1) % ring.size()]) - point(v));
      areas = areas + n;
      units = units + (1 / norm(n)) * n;
    }
    for (const Vec3 z : {(1 / norm(units)) * units, (1 / norm(areas)) * areas}) {
      if (is_axis(v, ring, z)) {
        *axis = z;
        return true;
      }
    }
    return false;
  }

  std::int32_t first_half(std::int32_t v, const std::vector<std::int32_t>& ring, Vec3 axis) const {
    const auto normal = [&](std::size_t i) {
      return cross(point(ring[(i + ring.size() - 1) % ring.size()]) - point(v), point(ring[i]) - point(v));
    };
    const Vec3 beside = cross(axis, normal(0));
    std::size_t i = 1;
    while (i < ring.size() && dot(beside, normal(i)) >= 0) ++i;
    return static_cast<std::int32_t>(i);
  }

  std::vector<std::int32_t> first_ring(std::int32_t v) const {
    if (h_.level[at(v)] == h_.depth) return coarsest_.ring(v);
    return {h_.rings.begin() + h_.ring_start[at(v)], h_.rings.begin() + h_.ring_start[at(v) + 1]};
  }

  void open(std::int32_t rim) {
    rim_.wedge[at(rim)] = static_cast<std::int32_t>(h_.wedges.size());
    h_.wedges.push_back({});
    h_.wedges.back().rim = rim;
  }

  std::int32_t child(const ChainRange& chain, std::int32_t i) const {
    return h_.blocks[at(chain.first_block + i / kBlockLanes)].id(at(i % kBlockLanes));
  }

  // Replays the removals around v, coarse to fine, level by level.
  void refine(std::int32_t v) {
    const ChainRange chain = h_.chains[at(v)];
    for (std::int32_t first = 0; first < chain.length;) {
      std::int32_t last = first;
      while (last < chain.length && h_.level[at(child(chain, last))] == h_.level[at(child(chain, first))]) ++last;
      std::vector<std::int32_t> appearing;
      for (; first < last; ++first) appearing.push_back(child(chain, first));
      insert(v, appearing);
    }
  }

  // The neighbours of v in c's ring; c appears between them in v's ring.
  void gap(std::int32_t v, std::int32_t c, std::int32_t* right, std::int32_t* left) const {
    const std::int32_t start = h_.ring_start[at(c)], size = h_.ring_start[at(c) + 1] - start;
    std::int32_t i = 0;
    while (h_.rings[at(start + i)] != v) ++i;
    *right = h_.rings[at(start + (i + 1) % size)];
    *left = h_.rings[at(start + (i + size - 1) % size)];
  }

  void insert(std::int32_t v, const std::vector<std::int32_t>& appearing) {
    struct Touched {
      std::int32_t rim, wedge;
    };
    std::vector<Touched> borders;
    for (const std::int32_t c : appearing) {
      std::int32_t right = 0, left = 0;  // v's ring becomes …, right, c, left, … counter-clockwise
      gap(v, c, &right, &left);
      open(c);
      const std::int32_t opened = rim_.wedge[at(c)];
      for (std::int32_t r = rim_.next[at(right)]; r != left; r = rim_.next[at(r)]) {
        WedgeNode& vanishing = h_.wedges[at(rim_.wedge[at(r)])];
        vanishing.left = c;
        vanishing.next_left = opened;
      }
      WedgeNode& on_right = h_.wedges[at(rim_.wedge[at(right)])];
      on_right.left = c;
      on_right.next_left = opened;
      WedgeNode& on_left = h_.wedges[at(rim_.wedge[at(left)])];
      on_left.right = c;
      on_left.next_right = opened;
      for (const std::int32_t r : {right, left}) borders.push_back({r, rim_.wedge[at(r)]});
    }
    for (const std::int32_t c : appearing) {
      std::int32_t right = 0, left = 0;
      gap(v, c, &right, &left);
      rim_.join(right, c);
      rim_.join(c, left);
    }
    for (const Touched& border : borders) {  // repeated where two holes border the same edge
      if (h_.wedges[at(border.wedge)].next >= 0) continue;
      open(border.rim);
      h_.wedges[at(border.wedge)].next = rim_.wedge[at(border.rim)];
    }
  }
};

}  // namespace

void build_wedges(const ConvexMesh& mesh, const Triangulation& coarsest, Levels& h) {
  const bool any =
      std::any_of(h.chains.begin(), h.chains.end(), [](const ChainRange& c) { return c.length > kLongChain; });
  if (!any) return;
  WedgeBuilder builder(mesh, coarsest, h);
  for (std::size_t v = 0; v < h.points.size(); ++v) {
    poll_interruption();
    if (h.chains[v].length > kLongChain) builder.build(static_cast<std::int32_t>(v));
  }
  link_chains(h);
}

std::string wedge_fault(const ConvexMesh& mesh, const Levels& h) {
  const Triangulation finest(mesh);
  for (std::size_t v = 0; v < h.points.size(); ++v) {
    if (h.fan_of[v] < 0) continue;
    const std::string name = " in the wedges of vertex " + std::to_string(v);
    const WedgeFan& fan = h.fans[at(h.fan_of[v])];
    std::vector<std::int32_t> ring = finest.ring(static_cast<std::int32_t>(v)), ends;
    for (const std::int32_t n : ring) {
      if (compare_along(fan.axis, h.points[v], h.points[at(n)]) <= 0) return "the axis is outside the cone" + name;
    }
    std::vector<std::int32_t> stack(h.entries.begin() + fan.first_entry,
                                    h.entries.begin() + fan.first_entry + fan.entries);
    std::vector<bool> seen(h.wedges.size());
    while (!stack.empty()) {
      const std::int32_t w = stack.back();
      stack.pop_back();
      if (seen[at(w)]) continue;
      seen[at(w)] = true;
      const WedgeNode& node = h.wedges[at(w)];
      if (node.left < 0 && node.right < 0) ends.push_back(node.rim);
      for (const std::int32_t next : {node.next_left, node.next, node.next_right}) {
        if (next >= 0) stack.push_back(next);
      }
    }
    std::sort(ring.begin(), ring.end());
    std::sort(ends.begin(), ends.end());
    if (ends != ring) return "the last edges are not the body's" + name;
  }
  return {};
}

}  // namespace plannercheck
