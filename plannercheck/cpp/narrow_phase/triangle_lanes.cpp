#include "narrow_phase/triangle_lanes.hpp"

#include "math/predicates.hpp"
#include "math/simd.hpp"

namespace plannercheck {
namespace {

// Rounds up the result of a few sums, products and roots of positive numbers.
constexpr double kLaneRoundedUp = 1 + 16 * kRoundoff;

struct LaneVec {
  Lanes x, y, z;
};

LaneVec operator-(const LaneVec& a, const LaneVec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
LaneVec operator-(const LaneVec& a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
LaneVec cross(const LaneVec& a, const LaneVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Lanes dot(const LaneVec& a, const LaneVec& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
Lanes dot(const LaneVec& a, Vec3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

// Bits of the lanes that are surely positive, and of those that are surely negative.
struct SignBits {
  unsigned above, below;
};

SignBits signs(Lanes volume, double bound) { return {bits(volume > bound), bits(volume < -bound)}; }

typedef std::array<LaneVec, 3> LaneCorners;

// The edges of a triangle, by the sides of the other triangle's plane: an edge whose ends are surely on one side passes
// it by.
struct EdgeSides {
  std::array<unsigned, 3> same, crosses;
};

EdgeSides edge_sides(const std::array<SignBits, 3>& s) {
  EdgeSides out;
  for (std::size_t k = 0; k < 3; ++k) {
    const SignBits &from = s[k], &to = s[k == 2 ? 0 : k + 1];
    out.same[k] = (from.above & to.above) | (from.below & to.below);
    out.crosses[k] = (from.above & to.below) | (from.below & to.above);
  }
  return out;
}

// Adds the answer of one edge: `a`, `b`, `c` say how its line passes the other triangle's edges.
void take_edge(const SignBits& a, const SignBits& b, const SignBits& c, unsigned same, unsigned crosses,
               TriangleLanes& out) {
  const unsigned above = a.above | b.above | c.above, below = a.below | b.below | c.below;
  const unsigned may_pass = ~(above & below) & ~same;
  const unsigned is_known = (a.above | a.below) & (b.above | b.below) & (c.above | c.below);
  out.meet |= may_pass & is_known & crosses;
  out.open |= may_pass;
}

// `bound`, `normal_error`: of volumes, and of the length of a triangle's normal.
TriangleLanes against(const TriangleCorners& t, const LaneCorners& c, double bound, double normal_error, double reach) {
  const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
  const double far = bound + reach * (norm(normal) + normal_error) * kLaneRoundedUp;
  std::array<SignBits, 3> of_c;
  unsigned apart_above = ~0U, apart_below = ~0U;
  for (std::size_t k = 0; k < 3; ++k) {
    const Lanes volume = dot(c[k] - t[0], normal);
    of_c[k] = signs(volume, bound);
    if (reach == 0) {
      apart_above &= of_c[k].above, apart_below &= of_c[k].below;
    } else {
      const SignBits beyond = signs(volume, far);
      apart_above &= beyond.above, apart_below &= beyond.below;
    }
  }
  constexpr unsigned kAll = (1U << kLanes) - 1;
  unsigned left = kAll & ~(apart_above | apart_below);
  if (left == 0) return {};
  const LaneVec normals = cross(c[1] - c[0], c[2] - c[0]);
  std::array<SignBits, 3> of_t;
  for (std::size_t k = 0; k < 3; ++k) {
    const LaneVec to{t[k].x - c[0].x, t[k].y - c[0].y, t[k].z - c[0].z};
    of_t[k] = signs(dot(normals, to), bound);
  }
  if (reach == 0) {
    left &= ~((of_t[0].above & of_t[1].above & of_t[2].above) | (of_t[0].below & of_t[1].below & of_t[2].below));
    if (left == 0) return {};
  }
  // The volume of edge i of the triangle with edge j of each other triangle.
  std::array<std::array<SignBits, 3>, 3> volume;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 from = t[i], way = t[i == 2 ? 0 : i + 1] - from;
    const LaneCorners to{c[0] - from, c[1] - from, c[2] - from};
    for (std::size_t j = 0; j < 3; ++j) volume[i][j] = signs(dot(cross(to[j], to[j == 2 ? 0 : j + 1]), way), bound);
  }
  const EdgeSides sides_t = edge_sides(of_t), sides_c = edge_sides(of_c);
  TriangleLanes out;
  for (std::size_t k = 0; k < 3; ++k) {
    take_edge(volume[k][0], volume[k][1], volume[k][2], sides_t.same[k], sides_t.crosses[k], out);
    take_edge(volume[0][k], volume[1][k], volume[2][k], sides_c.same[k], sides_c.crosses[k], out);
  }
  out.meet &= left;
  out.open = (reach == 0 ? out.open & left : left) & ~out.meet;
  return out;
}

}  // namespace

TriangleLanes triangle_against(const TriangleCorners& t, double error, const EightTriangles& leaf, std::size_t count,
                               double spread, double reach) {
  const unsigned all = (1U << count) - 1;
  if (!are_volumes_trusted(spread, error)) return {0, all};
  // A normal errs by 8L (e + uL) in each coordinate, L the spread and e the error: less than the bound over L.
  const double bound = volume_bound(spread, error), normal_error = bound / spread;
  TriangleLanes out;
  for (std::size_t first = 0; first < count; first += kLanes) {
    const auto lanes = [&](std::size_t k, std::size_t axis) { return load_lanes(&leaf.place[k][axis][first]); };
    const auto corner = [&](std::size_t k) { return LaneVec{lanes(k, 0), lanes(k, 1), lanes(k, 2)}; };
    const TriangleLanes part = against(t, {corner(0), corner(1), corner(2)}, bound, normal_error, reach);
    out.meet |= part.meet << first, out.open |= part.open << first;
  }
  out.meet &= all, out.open &= all;
  return out;
}

}  // namespace plannercheck
