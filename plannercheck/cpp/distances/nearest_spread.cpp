#include "distances/nearest_spread.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "narrow_phase/support.hpp"

namespace plannercheck {
namespace {

constexpr double kBoundless = std::numeric_limits<double>::infinity();

// Edges at a smaller angle leave their crossing too open, rad.
constexpr double kLeastAngle = 1e-3;

// The rounding of a height and of the direction turned into a body's frame, as in gjk.cpp, of both bodies' sizes;
// twice.
constexpr double kHeightRounding = 64 * 0x1p-53;

// How far all nearest points are from a vertex or an edge of a body.
struct Sharpness {
  double of_vertex = kBoundless, of_edge = kBoundless;
  Vec3 edge;  // in the world
};

class LowestVertices {
 public:
  LowestVertices(const PosedPolytope& posed, const HullEdges& edges, Vec3 along, double slack)
      : posed_(posed), edges_(edges), along_(posed.pose.rotate_back(along)), slack_(slack) {}

  Sharpness run(PairCounters& counters) const {
    const Polytope& body = *posed_.body;
    const std::int32_t first = extreme(body.inner, -along_, counters.queries);
    const Next second = lowest_neighbour(first, -1);
    Sharpness out{within(height(second.vertex, first)), kBoundless, {}};
    if (second.vertex < 0) return out;
    const Next third = lower(lowest_neighbour(first, second.vertex), lowest_neighbour(second.vertex, first));
    out.of_edge = within(height(third.vertex, first));
    out.edge = unit(posed_.pose.rotate(point(second.vertex) - point(first)));
    return out;
  }

 private:
  const PosedPolytope& posed_;
  const HullEdges& edges_;
  Vec3 along_;
  double slack_;

  struct Next {
    std::int32_t vertex = -1;
    double height = kBoundless;
  };

  Vec3 point(std::int32_t vertex) const { return posed_.body->inner.points[at(vertex)]; }
  double height(std::int32_t vertex, std::int32_t over) const {
    return vertex < 0 ? kBoundless : dot(along_, point(vertex) - point(over));
  }
  static Next lower(Next a, Next b) { return b.height < a.height ? b : a; }

  Next lowest_neighbour(std::int32_t vertex, std::int32_t besides) const {
    Next out;
    for (std::int32_t k = edges_.starts[at(vertex)]; k < edges_.starts[at(vertex) + 1]; ++k) {
      const std::int32_t end = edges_.ends[at(k)];
      if (end != besides) out = lower(out, {end, dot(along_, point(end))});
    }
    return out;
  }

  // `height`: where all other vertices begin, above the lowest one.
  double within(double height) const {
    if (std::isinf(height)) return 0;
    return height > slack_ ? slack_ / (height - slack_) * 2 * posed_.body->radius : kBoundless;
  }
};

}  // namespace

HullEdges edges_of(const Polytope& body) {
  const std::size_t count = body.inner.points.size();
  std::vector<std::array<std::int32_t, 2>> pairs;
  for (const Triangle& t : body.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::int32_t>(t[k]), b = static_cast<std::int32_t>(t[(k + 1) % 3]);
      pairs.push_back({a, b}), pairs.push_back({b, a});
    }
  }
  if (pairs.empty()) {  // points and segments
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t j = 0; j < count; ++j) {
        if (j != k) pairs.push_back({static_cast<std::int32_t>(k), static_cast<std::int32_t>(j)});
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  HullEdges out;
  out.starts.assign(count + 1, 0);
  for (const auto& [from, to] : pairs) {
    ++out.starts[at(from) + 1];
    out.ends.push_back(to);
  }
  for (std::size_t v = 0; v < count; ++v) out.starts[v + 1] += out.starts[v];
  return out;
}

double nearest_spread(const PosedPolytope& body_a, const HullEdges& edges_a, const PosedPolytope& body_b,
                      const HullEdges& edges_b, const PairDistance& found, PairCounters& counters) {
  const double size = body_a.body->origin_radius + body_b.body->origin_radius +
                      norm_1(body_a.pose.translation() - body_b.pose.translation());
  const double slack = larger(found.upper - found.lower, 0) + kHeightRounding * size;
  const bool flat_a = !body_a.body->traits().is_bounded, flat_b = !body_b.body->traits().is_bounded;
  const Sharpness a = flat_a ? Sharpness{} : LowestVertices(body_a, edges_a, found.direction, slack).run(counters);
  const Sharpness b = flat_b ? Sharpness{} : LowestVertices(body_b, edges_b, -found.direction, slack).run(counters);
  const double spread = 2 * std::min(a.of_vertex, b.of_vertex);
  if (std::isinf(a.of_edge) || std::isinf(b.of_edge)) return spread;
  const double sine = norm(cross(a.edge, b.edge));
  return sine < kLeastAngle ? spread : std::min(spread, 2 * (a.of_edge + b.of_edge) / sine);
}

}  // namespace plannercheck
