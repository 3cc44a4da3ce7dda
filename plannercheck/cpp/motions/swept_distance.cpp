#include "motions/swept_distance.hpp"

#include <algorithm>
#include <limits>

namespace plannercheck {
namespace {

constexpr int kDescentRounds = 48;

// A new difference that is nearer by less than this part is no progress.
constexpr double kDescentProgress = 1e-12;

// The rounding of a face's normal, and of products with it.
constexpr double kFaceRounding = 32 * 0x1p-53;

struct Difference {
  Vec3 point;  // in the frame
  double along;
};

Difference difference_at(const Polytope& a, const Polytope& b, const PosedPair& pose, Vec3 direction,
                         PairCounters& counters) {
  ++counters.queries_a, ++counters.queries_b;
  const Vec3 d = pose.frame.to_world(direction);
  const auto p = static_cast<std::size_t>(extreme(a.inner, -pose.a.rotate_back(d), counters.queries));
  const auto r = static_cast<std::size_t>(extreme(b.inner, pose.b.rotate_back(d), counters.queries));
  const Vec3 w = pose.a.apply(a.inner.points[p]) - pose.b.apply(b.inner.points[r]);
  return {pose.frame.from_world(w), dot(d, w)};
}

// Up to four points, reduced to the corners of the face that holds the point nearest to the origin.
struct NearSimplex {
  int count = 0;
  std::array<Vec3, 4> point;
};

Vec3 nearest_on_segment(NearSimplex& s, Vec3 a, Vec3 b) {
  const Vec3 ab = b - a;
  const double t = -dot(a, ab), square = dot(ab, ab);
  if (t <= 0) return s = {1, {a}}, a;
  if (t >= square) return s = {1, {b}}, b;
  return s = {2, {a, b}}, a + (t / square) * ab;
}

// Voronoi regions as in Ericson, "Real-Time Collision Detection", section 5.1.5.
Vec3 nearest_on_triangle(NearSimplex& s, Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a), d3 = -dot(ab, b), d4 = -dot(ac, b), d5 = -dot(ab, c),
               d6 = -dot(ac, c);
  if (d1 <= 0 && d2 <= 0) return s = {1, {a}}, a;
  if (d3 >= 0 && d4 <= d3) return s = {1, {b}}, b;
  if (d6 >= 0 && d5 <= d6) return s = {1, {c}}, c;
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return nearest_on_segment(s, a, b);
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return nearest_on_segment(s, a, c);
  if (va <= 0 && d4 >= d3 && d5 >= d6) return nearest_on_segment(s, b, c);
  const double scale = 1 / (va + vb + vc);
  if (!std::isfinite(scale)) return nearest_on_segment(s, a, b);
  s = {3, {a, b, c}};
  return a + (vb * scale) * ab + (vc * scale) * ac;
}

// The corners of each face of a tetrahedron, and the other one.
constexpr std::array<std::array<std::size_t, 4>, 4> kSimplexFaces{
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}};

// The nearest point of a tetrahedron. If the origin is inside, the origin itself, and all four corners are kept.
Vec3 nearest_on_tetrahedron(NearSimplex& s) {
  const std::array<Vec3, 4> p = s.point;
  bool outside = false;
  double least = 0;
  Vec3 best;
  for (const auto& f : kSimplexFaces) {
    const Vec3 n = cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]]);
    const double origin = -dot(n, p[f[0]]), opposite = dot(n, p[f[3]] - p[f[0]]);
    if (origin * opposite > 0) continue;
    NearSimplex face;
    const Vec3 v = nearest_on_triangle(face, p[f[0]], p[f[1]], p[f[2]]);
    const double square = dot(v, v);
    if (outside && square >= least) continue;
    outside = true, least = square, best = v, s = face;
  }
  return outside ? best : Vec3{};
}

// A lower bound of how far the origin is inside a tetrahedron; 0 if it is not, or if the tetrahedron is too flat to
// tell. A normal errs by at most 8u of its edges' product, in |.|_1, and a product with it by as much of both.
double depth_inside(const NearSimplex& s) {
  const auto& p = s.point;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& f : kSimplexFaces) {
    const Vec3 first = p[f[1]] - p[f[0]], second = p[f[2]] - p[f[0]], third = p[f[3]] - p[f[0]];
    const Vec3 n = cross(first, second);
    const double error = kFaceRounding * norm_1(first) * norm_1(second);
    const double origin = -dot(n, p[f[0]]), opposite = dot(n, third);
    const double apart = std::fabs(origin) - error * norm_1(p[f[0]]);
    if (!(origin * opposite > 0 && std::fabs(opposite) > error * norm_1(third) && apart > 0)) return 0;
    least = smaller(least, apart / (norm(n) + error));
  }
  return least;
}

Vec3 nearest(NearSimplex& s) {
  switch (s.count) {
    case 1:
      return s.point[0];
    case 2:
      return nearest_on_segment(s, s.point[0], s.point[1]);
    case 3:
      return nearest_on_triangle(s, s.point[0], s.point[1], s.point[2]);
    default:
      return nearest_on_tetrahedron(s);
  }
}

}  // namespace

double gap_along(const Polytope& a, const Polytope& b, const PosedPair& pose, Vec3 direction, PairCounters& counters) {
  return difference_at(a, b, pose, direction, counters).along;
}

SweptAnswer<Vec3> swept_distance(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit,
                                 Vec3 hint, PairCounters& counters) {
  SweptAnswer<Vec3> answer;
  NearSimplex simplex;
  Vec3 v = norm_1(hint) > 0 ? hint : Vec3{1, 0, 0};
  double square = 0;  // |v|² once v is a point of the simplex
  for (int round = 0; round < kDescentRounds; ++round) {
    ++counters.rounds;
    const double length = norm(v);
    if (!(length > kTrustedLength) || !std::isfinite(length)) return answer;
    const Vec3 d = (1 / length) * v;
    Difference lowest = difference_at(a, b, poses[0], d, counters);
    for (int p = 1; p < count; ++p) {
      const Difference other = difference_at(a, b, poses[p], d, counters);
      if (other.along < lowest.along) lowest = other;
    }
    if (round == 0 || lowest.along > answer.gap) answer.direction = d, answer.gap = lowest.along;
    answer.apart = lowest.along > limit;
    if (answer.apart) return answer;
    // The new vertex is no nearer to the origin than the simplex: as near as doubles can tell.
    if (simplex.count > 0 && length - lowest.along <= kDescentProgress * length) return answer;
    simplex.point[static_cast<std::size_t>(simplex.count++)] = lowest.point;
    v = nearest(simplex);
    const double now = dot(v, v);
    if (simplex.count == 4) answer.inside = depth_inside(simplex);
    if (now <= limit * limit || simplex.count == 4 || (round > 0 && now >= square)) return answer;
    square = now;
  }
  return answer;
}

}  // namespace plannercheck
