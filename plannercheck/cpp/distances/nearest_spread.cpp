#include "distances/nearest_spread.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "narrow_phase/expanding_polytope.hpp"
#include "narrow_phase/support.hpp"

namespace plannercheck {
namespace {

// Edges at a smaller angle leave their crossing too open, and faces at a larger turn are too large, rad.
constexpr double kLeastAngle = 1e-3, kWidestTurn = 0.1;

// The rounding of a height and of the direction turned into a body's frame, as in gjk.cpp, of both bodies' sizes;
// twice.
constexpr double kHeightRounding = 64 * 0x1p-53;

// Bodies apart by less than the bounds' distance over this leave the normal too open.
constexpr double kNormalError = 1e-8;

using VertexSet = std::vector<std::int32_t>;
constexpr std::size_t kAllVertices = std::numeric_limits<std::size_t>::max();

class ConvexPair {
 public:
  ConvexPair(const PosedPolytope& a, const PosedPolytope& b, const PairDistance& found, PairCounters& counters)
      : a_(a),
        b_(b),
        found_(found),
        counters_(counters),
        size_(size_of(a) + size_of(b) + (is_bounded() ? norm_1(a.pose.translation() - b.pose.translation()) : 0)),
        rounding_(kHeightRounding * size_),
        upper_(found.upper + a.body->inflation_radius + b.body->inflation_radius),
        overlap_(upper_ < 0 && is_bounded()) {}

  // A bound of how far the directions of nearest differences are from the normal.
  double turn() const {
    if (!is_bounded()) return 0;
    if (overlap_) return found_.turn;
    const double slack = larger(found_.upper - found_.lower, 0) + rounding_;
    return slack < kNormalError * upper_ ? std::sqrt(2 * slack / upper_) : kNoLimit;
  }

  // All vertices of sets that are no larger than `most`; of others some, more than `most`.
  VertexSet face_of_a(const HullEdges& edges, double turn, std::size_t most = kAllVertices) const {
    return face(a_, edges, found_.direction, turn, most);
  }
  VertexSet face_of_b(const HullEdges& edges, double turn, std::size_t most = kAllVertices) const {
    return face(b_, edges, -found_.direction, turn, most);
  }

  // For bodies apart, a single vertex of A decides, and of more than two vertices only that they are more matters.
  double spread(const HullEdges& edges_a, const HullEdges& edges_b, double turn) const {
    const std::size_t most = overlap_ ? kAllVertices : 2;
    const VertexSet face_a = face_of_a(edges_a, turn, most);
    return spread(face_a, face_a.size() == 1 && !overlap_ ? VertexSet{} : face_of_b(edges_b, turn, most), turn);
  }

  double spread(const VertexSet& face_a, const VertexSet& face_b, double turn) const {
    const Vec3 n = found_.direction;
    const double off_a = off(a_, face_a, found_.on_body_a + a_.body->inflation_radius * n);
    const double off_b = off(b_, face_b, found_.on_body_b - b_.body->inflation_radius * n);
    if (face_a.size() == 1) return off_a + (overlap_ ? size_ * tilt(b_, face_b, turn) : 0);
    if (face_b.size() == 1) return off_b + (overlap_ ? size_ * tilt(a_, face_a, turn) : 0);
    if (face_a.size() != 2 || face_b.size() != 2) return kNoLimit;
    const Vec3 across = cross(edge(a_, face_a), edge(b_, face_b));
    const double sine = norm(across);
    return sine < kLeastAngle ? kNoLimit : (off_a + off_b + size_ * apart((1 / sine) * across, n)) / sine;
  }

 private:
  const PosedPolytope &a_, &b_;
  const PairDistance& found_;
  PairCounters& counters_;
  double size_, rounding_, upper_;  // `upper_`: without the inflation radii
  bool overlap_;

  static double size_of(const PosedPolytope& body) {
    return body.body->traits().is_bounded ? body.body->origin_radius + body.body->inflation_radius : 0;
  }
  bool is_bounded() const { return a_.body->traits().is_bounded && b_.body->traits().is_bounded; }

  // The set of vertices that holds the face, of equal ones one; of a half-space none.
  VertexSet face(const PosedPolytope& posed, const HullEdges& edges, Vec3 normal, double turn, std::size_t most) const {
    if (!posed.body->traits().is_bounded) return {};
    const std::vector<Vec3>& points = posed.body->inner.points;
    const Vec3 along = posed.pose.rotate_back(normal);
    VertexSet out{extreme(posed.body->inner, -along, counters_.queries)};
    for (std::size_t k = 0; k < out.size() && out.size() <= most; ++k) {
      for (std::int32_t e = edges.starts[at(out[k])]; e < edges.starts[at(out[k]) + 1]; ++e) {
        const Vec3 end = points[at(edges.ends[at(e)])], step = end - points[at(out[k])];
        const bool ascends = dot(along, step) > turn * norm(step) + rounding_;
        const auto is_end = [&](std::int32_t v) { return points[at(v)] == end; };
        if (!ascends && std::none_of(out.begin(), out.end(), is_end)) out.push_back(edges.ends[at(e)]);
      }
    }
    return out;
  }

  static Vec3 vertex(const PosedPolytope& posed, std::int32_t v) {
    return posed.pose.apply(posed.body->inner.points[at(v)]);
  }
  static Vec3 edge(const PosedPolytope& posed, const VertexSet& face) {
    return unit(vertex(posed, face[1]) - vertex(posed, face[0]));
  }
  // The distance of two directions, whatever their signs.
  static double apart(Vec3 d, Vec3 e) { return smaller(norm(d - e), norm(d + e)); }

  // How far a point is from a vertex or an edge's line, beyond rounding.
  double off(const PosedPolytope& posed, const VertexSet& face, Vec3 point) const {
    if (face.empty() || face.size() > 2) return 0;
    const Vec3 from = point - vertex(posed, face[0]);
    return larger(norm(face.size() == 1 ? from : cross(edge(posed, face), from)) - rounding_, 0);
  }

  // How far the normals of a hull's facets, of which all vertices are in a set, are from the normal: of those within
  // the turn, which frames change by far less than once more. Infinite if there are none.
  double tilt(const PosedPolytope& posed, const VertexSet& of, double turn) const {
    const std::vector<Vec3>& points = posed.body->inner.points;
    const Vec3 along = unit(posed.pose.rotate_back(found_.direction));
    const auto holds = [&](auto v) {
      return std::find(of.begin(), of.end(), static_cast<std::int32_t>(v)) != of.end();
    };
    double most = -1;
    for (const Triangle& t : posed.body->triangles) {
      if (!holds(t[0]) || !holds(t[1]) || !holds(t[2])) continue;
      const double off = apart(FinePlane(points[at(t[0])], points[at(t[1])], points[at(t[2])]).normal, along);
      if (off <= 2 * turn) most = larger(most, off);
    }
    return most < 0 ? kNoLimit : most;
  }
};

struct NearestFaces {
  VertexSet a, b;
  double spread = kNoLimit;
};

NearestFaces nearest_faces(const PosedPolytope& a, const HullEdges& edges_a, const PosedPolytope& b,
                           const HullEdges& edges_b, const PairDistance& found, PairCounters& counters) {
  const ConvexPair pair(a, b, found, counters);
  const double turn = pair.turn();
  if (!(turn < kWidestTurn)) return {};
  NearestFaces out{pair.face_of_a(edges_a, turn), pair.face_of_b(edges_b, turn)};
  out.spread = pair.spread(out.a, out.b, turn);
  return out;
}

std::vector<Vec3> sorted_points(const PosedPolytope& posed, const VertexSet& face) {
  std::vector<Vec3> out;
  for (const std::int32_t v : face) out.push_back(posed.body->inner.points[at(v)]);
  std::sort(out.begin(), out.end(), [](Vec3 a, Vec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
  return out;
}

}  // namespace

double normal_turn(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairDistance& found,
                   PairCounters& counters) {
  return ConvexPair(body_a, body_b, found, counters).turn();
}

HullEdges edges_of(const Polytope& body) {
  const std::size_t count = body.inner.points.size();
  std::vector<std::array<std::int32_t, 2>> pairs;
  for (const Triangle& t : body.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::int32_t>(t[k]), b = static_cast<std::int32_t>(t[(k + 1) % 3]);
      pairs.push_back({a, b}), pairs.push_back({b, a});
    }
  }
  if (pairs.empty()) {
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
  const ConvexPair pair(body_a, body_b, found, counters);
  const double turn = pair.turn();
  return turn < kWidestTurn ? pair.spread(edges_a, edges_b, turn) : kNoLimit;
}

void NearestParts::add(const PosedPolytope& body_a, const HullEdges& edges_a, const PosedPolytope& body_b,
                       const HullEdges& edges_b, const PairDistance& found, PairCounters& counters) {
  if (found.lower > upper_) return;
  upper_ = smaller(upper_, found.upper);
  const NearestFaces faces = nearest_faces(body_a, edges_a, body_b, edges_b, found, counters);
  candidates_.push_back({found.lower, faces.spread, sorted_points(body_a, faces.a), sorted_points(body_b, faces.b)});
}

double NearestParts::spread() const {
  const Candidate* first = nullptr;
  double most = 0;
  for (const Candidate& candidate : candidates_) {
    if (candidate.lower > upper_) continue;
    if (first == nullptr) first = &candidate;
    if (candidate.face_a != first->face_a || candidate.face_b != first->face_b) return kNoLimit;
    most = larger(most, candidate.spread);
  }
  return first == nullptr ? kNoLimit : most;
}

}  // namespace plannercheck
