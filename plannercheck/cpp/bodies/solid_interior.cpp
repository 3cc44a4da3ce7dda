#include "bodies/solid_interior.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "bodies/inner_shape_search.hpp"
#include "bodies/lane_boxes.hpp"
#include "bodies/solid.hpp"
#include "math/box.hpp"
#include "math/predicates.hpp"
#include "math/simd.hpp"

namespace plannercheck {
namespace {

// The error of a corner's place along a direction, less the place of a box or point, as a part of the solid's size |x|
// + |y| + |z|: differences of coordinates, at most twice the size, err by u, the direction by 4u, products and sums by
// 4u. Half extents and the sum with them add 4u.
constexpr double kPlaneAlongError = 64 * 0x1p-53;

// Places in floats of the tree's units, and squares of distances there, err by less than this part.
constexpr double kFloatPlace = 0x1p-20;

// Sizes whose products of six neither overflow nor underflow.
constexpr double kLeastSize = 1e-40, kLargestSize = 1e40;

// Flatter solids hold too little to be worth looking for, which takes minutes where edges are a billionth of others.
constexpr double kFlattest = 1e-6;

// A ball moves away from what it touches, by this part of its radius at first, in so many steps, as long as it grows
// by so much.
constexpr double kMove = 0.9, kGrowth = 1.05;
constexpr int kMoves = 3;

// So many triangles have balls tried on either side, by this part of the least edge of the box around the solid.
constexpr std::size_t kTriedTriangles = 64;
constexpr double kOffTriangle = 1.0 / 32;

typedef std::array<Vec3, 3> Triangle3;

// The point of a triangle closest to the origin, up to rounding (Ericson, Real-Time Collision Detection, 5.1.5).
Vec3 closest_to_origin(const Triangle3& t) {
  const Vec3 a = t[0], b = t[1], c = t[2], ab = b - a, ac = c - a, bc = c - b;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a), d3 = -dot(ab, b), d4 = -dot(ac, b), d5 = -dot(ab, c),
               d6 = -dot(ac, c);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * bc;
  const double sum = va + vb + vc;
  return a + (vb / sum) * ab + (vc / sum) * ac;
}

struct NearestTriangle {
  double distance;  // at most the exact one
  Vec3 way;         // to the nearest point
};

class SolidInterior {
 public:
  explicit SolidInterior(const Solid& solid) : solid_(solid), tree_(solid.tree), size_(norm_1(solid.reach)) {
    room_ = kPlaneAlongError * size_;
  }

  bool is_known() const { return size_ > kLeastSize && size_ < kLargestSize; }

  // Whether the solid surely winds around a point.
  bool winds_around(Vec3 point) const {
    const std::array<float, 3> place = in_units(point);
    const auto room = static_cast<float>(8 * kFloatPlace);
    int number = 0;
    const bool is_unclear = any_triangle(
        tree_, [&](const TriangleNode& node) { return children_on_ray(node, place, room); },
        [&](std::int32_t triangle) {
          const std::optional<int> crossing = crossed(solid_.triangles[at(triangle)], point);
          number += crossing.value_or(0);
          return !crossing;
        });
    return !is_unclear && number != 0;
  }

  // The nearest triangle, by a descent into nearer children first.
  NearestTriangle nearest(Vec3 point) const {
    NearestTriangle best{std::numeric_limits<double>::infinity(), {}};
    const std::array<float, 3> place = in_units(point);
    std::array<std::pair<std::int32_t, float>, kMostWaiting> waiting;
    std::size_t count = 0;
    waiting[count++] = {0, 0};
    while (count > 0) {
      const auto [index, square] = waiting[--count];
      if (is_beyond(square, best.distance)) continue;
      const TriangleNode& node = tree_.nodes[at(index)];
      if (node.leaf >= 0) {
        take_nearest(node, point, best);
        continue;
      }
      const std::size_t first = count;
      const Floats squares = squares_to(node, place);
      for (std::size_t k = 0; k < node.children; ++k) {
        if (is_beyond(squares[k], best.distance)) continue;
        std::size_t spot = count++;
        for (; spot > first && waiting[spot - 1].second < squares[k]; --spot) waiting[spot] = waiting[spot - 1];
        waiting[spot] = {node.child(k), squares[k]};
      }
    }
    best.distance = smaller(best.distance, size_) - room_;
    return best;
  }

  // Whether all triangles are surely further from the box than its radius.
  bool holds(const InnerBox& box) const {
    const Vec3 middle = 0.5 * (box.low + box.high);
    // Differences, which are rounded, are taken up to twice the room.
    const Vec3 half = larger(box.high - middle, middle - box.low);
    const double radius = box.radius + room_;
    const std::array<float, 3> place = in_units(middle);
    std::array<float, 3> reach;
    for (std::size_t i = 0; i < 3; ++i) {
      reach[i] = static_cast<float>(tree_.units * (half[i] + radius) + 8 * kFloatPlace);
    }
    return !any_triangle(
        tree_, [&](const TriangleNode& node) { return children_within(node, place, reach); },
        [&](std::int32_t triangle) {
          const std::size_t leaf = at(triangle) / kTreeWidth, k = at(triangle) % kTreeWidth;
          return !is_further(from(tree_.leaves[leaf], k, middle), half, radius);
        });
  }

 private:
  static constexpr std::size_t kMostWaiting = TriangleTree::kMostLevels * kTreeWidth;

  const Solid& solid_;
  const TriangleTree& tree_;
  double size_, room_;

  std::array<float, 3> in_units(Vec3 p) const {
    const Vec3 place = tree_.units * (p - tree_.middle);
    return {static_cast<float>(place.x), static_cast<float>(place.y), static_cast<float>(place.z)};
  }

  static Triangle3 from(const EightTriangles& leaf, std::size_t k, Vec3 origin) {
    const auto t = leaf.corners(k);
    return {t[0] - origin, t[1] - origin, t[2] - origin};
  }

  static Floats squares_to(const TriangleNode& node, const std::array<float, 3>& place) {
    const LaneBoxes boxes = lane_boxes(node);
    const std::array<Floats, 3> around = aligned_half(boxes);
    Floats sum{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Floats beyond = larger(absolute(boxes.centre[i] - place[i]) - around[i], Floats{});
      sum += beyond * beyond;
    }
    return sum;
  }

  // Whether boxes at this distance, in floats, are surely further away than a distance in m. Points are inside of the
  // box around the solid, or hardly outside.
  bool is_beyond(float square, double distance) const {
    const double limit = tree_.units * distance * (1 + 8 * kFloatPlace) + 8 * kFloatPlace;
    return static_cast<double>(square) > limit * limit;
  }

  void take_nearest(const TriangleNode& node, Vec3 point, NearestTriangle& best) const {
    for (std::size_t k = 0; k < node.children; ++k) {
      const Triangle3 t = from(tree_.leaves[at(node.leaf)], k, point);
      const Vec3 way = closest_to_origin(t);
      const double square = dot(way, way);
      if (!(square < best.distance * best.distance)) continue;
      const Vec3 along = (1 / std::sqrt(square)) * way;
      const double distance = smaller(dot(along, t[0]), smaller(dot(along, t[1]), dot(along, t[2])));
      // Where the closest point is rounded badly, or the point is on the triangle, nothing is known.
      best = {distance > 0 ? smaller(distance, best.distance) : 0, way};
    }
  }

  // Whether a direction keeps a triangle, relative to the middle of a box, further from that than the radius.
  static bool is_further(const Triangle3& t, Vec3 half, double radius) {
    const auto separates = [&](Vec3 d) {
      const double a = dot(d, t[0]), b = dot(d, t[1]), c = dot(d, t[2]);
      const double least = smaller(a, smaller(b, c)), most = larger(a, larger(b, c));
      const double around = std::fabs(d.x) * half.x + std::fabs(d.y) * half.y + std::fabs(d.z) * half.z;
      return larger(least, -most) - around > radius;
    };
    const auto separates_along = [&](Vec3 d) { return norm_1(d) > 0 && separates(unit(d)); };
    const std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    for (const Vec3 axis : axes) {
      if (separates(axis)) return true;
    }
    if (separates_along(cross(t[1] - t[0], t[2] - t[0]))) return true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 edge = t[k == 2 ? 0 : k + 1] - t[k];
      for (const Vec3 axis : axes) {
        if (separates_along(cross(edge, axis))) return true;
      }
    }
    return false;
  }

  // How often a triangle is crossed upwards from a point, downwards counted as −1; nothing if the ray's line meets the
  // triangle's edges, or the point its plane.
  std::optional<int> crossed(const MeshTriangle& t, Vec3 point) const {
    const Vec3 a = solid_.points[at(t[0])], b = solid_.points[at(t[1])], c = solid_.points[at(t[2])];
    const std::array<int, 3> turns{turn(point, a, b, 2), turn(point, b, c, 2), turn(point, c, a, 2)};
    bool left = false, right = false;
    for (const int sign : turns) left |= sign > 0, right |= sign < 0;
    if (left && right) return 0;
    if (turns[0] == 0 || turns[1] == 0 || turns[2] == 0) return {};
    const int side = orientation(a, b, c, point);
    if (side == 0) return {};
    return left == (side < 0) ? turns[0] : 0;
  }
};

// The ball of a point, moved to where it can be larger; it stays in the same part of the solid.
InnerBall moved(const SolidInterior& interior, Vec3 centre) {
  NearestTriangle nearest = interior.nearest(centre);
  double step = kMove;
  for (int k = 0; k < kMoves && nearest.distance > 0; ++k) {
    const Vec3 next = centre - (step * nearest.distance / norm(nearest.way)) * nearest.way;
    const NearestTriangle there = interior.nearest(next);
    if (there.distance > kGrowth * nearest.distance) {
      centre = next, nearest = there;
    } else {
      step /= 2;
    }
  }
  return {centre, nearest.distance};
}

std::vector<InnerBall> balls_in(const Solid& solid, const SolidInterior& interior, const Box& box) {
  std::vector<InnerBall> balls;
  const auto try_around = [&](Vec3 point) {
    if (!interior.winds_around(point)) return;
    const InnerBall ball = moved(interior, point);
    if (ball.radius > 0) balls.push_back(ball);
  };
  try_around(0.5 * (box.low + box.high));
  for (int k = 0; k < kSpreadPoints && balls.size() < kTriedCentres; ++k)
    try_around(spread_point(box.low, box.high, k));
  const Vec3 edges = box.high - box.low;
  const double off = kOffTriangle * smaller(edges.x, smaller(edges.y, edges.z));
  const std::size_t stride = (solid.triangles.size() + kTriedTriangles - 1) / kTriedTriangles;
  for (std::size_t k = 0; k < solid.triangles.size(); k += stride) {
    const MeshTriangle& t = solid.triangles[k];
    const Vec3 a = solid.points[at(t[0])], b = solid.points[at(t[1])], c = solid.points[at(t[2])];
    const Vec3 normal = cross(b - a, c - a);
    if (norm_1(normal) == 0) continue;
    for (const double side : {-off, off}) try_around((1.0 / 3) * (a + b + c) + side * unit(normal));
  }
  return balls;
}

}  // namespace

bool surely_winds_around(const Solid& solid, Vec3 point) {
  const SolidInterior interior(solid);
  return interior.is_known() && interior.winds_around(point);
}

double inner_radius(const Solid& solid, Vec3 point) {
  const SolidInterior interior(solid);
  const bool is_inside = solid.is_closed && interior.is_known() && interior.winds_around(point);
  return is_inside ? larger(interior.nearest(point).distance, 0) : 0;
}

InnerShapes inner_shapes_of(const Solid& solid) {
  InnerShapes shapes;
  const SolidInterior interior(solid);
  if (!solid.is_closed || !interior.is_known()) return shapes;
  const Box box = box_around(solid.points);
  const Vec3 edges = box.high - box.low;
  if (smaller(edges.x, smaller(edges.y, edges.z)) < kFlattest * norm_max(edges)) return shapes;
  const std::vector<InnerBall> balls = balls_in(solid, interior, box);
  if (balls.empty()) return shapes;
  shapes.balls = covering(balls);
  shapes.box = largest_box(interior, edges, balls);
  return shapes;
}

}  // namespace plannercheck
