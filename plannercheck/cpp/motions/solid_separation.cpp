#include "motions/solid_separation.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "bodies/lane_boxes.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kDirections = 6, kMostPoses = 2;

// Projections in floats err by this times the entries of all directions: middles of boxes are within 1, half extents
// add up to √3 times the box's own, and roundings are at most nine, one after another.
constexpr float kProjectionError = 0x1p-19F;

// What denormal floats lose, in m.
constexpr float kDenormalFloats = 1e-37F;

using TrianglePoints = std::array<Vec3, 3>;

// What a direction makes of a tree's boxes at a pose: where their middles are along it, and how far they reach.
struct Projection {
  std::array<float, 3> along;
  float offset = 0;

  float centre(const OrientedBox& box) const {
    return (along[0] * box.centre[0] + along[1] * box.centre[1]) + (along[2] * box.centre[2] + offset);
  }
  float half(const OrientedBox& box) const {
    float sum = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const auto& axis = box.axis[j];
      sum += box.half[j] * std::fabs((along[0] * axis[0] + along[1] * axis[1]) + along[2] * axis[2]);
    }
    return sum;
  }
  Floats centres(const LaneBoxes& boxes) const { return product(boxes.centre) + offset; }
  Floats halves(const LaneBoxes& boxes) const {
    Floats sum{};
    for (std::size_t j = 0; j < 3; ++j) sum += boxes.half[j] * absolute(product(boxes.axis[j]));
    return sum;
  }

 private:
  Floats product(const std::array<Floats, 3>& v) const { return (along[0] * v[0] + along[1] * v[1]) + along[2] * v[2]; }
};

struct Projected {
  Projection a, b;
  float limit;  // errors included
};

Projection projection(const Solid& solid, const Pose& pose, Vec3 direction, double offset) {
  const Vec3 along = (1 / solid.tree.units) * pose.rotate_back(direction);
  Projection out;
  for (std::size_t k = 0; k < 3; ++k) {
    out.along[k] = static_cast<float>(along[k]);
  }
  out.offset = static_cast<float>(offset);
  return out;
}

double sum_of(const Projection& p) {
  const auto size = [](float entry) { return std::fabs(static_cast<double>(entry)); };
  return size(p.along[0]) + size(p.along[1]) + size(p.along[2]) + size(p.offset);
}

// The part of a way along a segment that starts at 0, where it ends or before.
double clamped(double part) { return larger(0, smaller(1, part)); }

// From a point to the closest one of a triangle's inside, if its plane is closest there; else nothing is taken.
void take_face(const TrianglePoints& t, Vec3 point, double sign, Vec3& best, double& square) {
  const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
  const double length = dot(normal, normal);
  if (!(length > 0)) return;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 from = t[k], edge = t[k == 2 ? 0 : k + 1] - from;
    if (dot(cross(edge, point - from), normal) < 0) return;
  }
  const double height = dot(normal, t[0] - point) / length;
  const Vec3 way = (sign * height) * normal;
  if (dot(way, way) < square) best = way, square = dot(way, way);
}

// Between two segments (Ericson, Real-Time Collision Detection, 5.1.9).
void take_edges(Vec3 p, Vec3 u, Vec3 q, Vec3 v, Vec3& best, double& square) {
  const Vec3 r = p - q;
  const double a = dot(u, u), e = dot(v, v), b = dot(u, v), c = dot(u, r), f = dot(v, r), across = a * e - b * b;
  double s = across > 0 ? clamped((b * f - c * e) / across) : 0;
  double t = e > 0 ? (b * s + f) / e : 0;
  if (t < 0 || t > 1) t = clamped(t), s = a > 0 ? clamped((b * t - c) / a) : 0;
  const Vec3 way = (q + t * v) - (p + s * u);
  if (dot(way, way) < square) best = way, square = dot(way, way);
}

// From the closest point of one triangle to that of the other, up to rounding; they do not meet.
Vec3 closest_way(const TrianglePoints& a, const TrianglePoints& b) {
  Vec3 best;
  double square = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    take_face(b, a[i], 1, best, square);
    take_face(a, b[i], -1, best, square);
    const Vec3 u = a[i == 2 ? 0 : i + 1] - a[i];
    for (std::size_t j = 0; j < 3; ++j) take_edges(a[i], u, b[j], b[j == 2 ? 0 : j + 1] - b[j], best, square);
  }
  return best;
}

class Separation {
 public:
  Separation(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit)
      : a_(a.surface()),
        b_(b.surface()),
        poses_(poses),
        count_(static_cast<std::size_t>(count)),
        limit_(limit),
        scale_(static_cast<float>(b_.tree.units / a_.tree.units)) {
    for (std::size_t k = 0; k < kDirections; ++k) project(k);
  }

  bool run() {
    std::array<std::pair<BoxedNode, BoxedNode>, kMostWaiting> waiting;
    std::size_t count = 0;
    waiting[count++] = {{0, a_.tree.root}, {0, b_.tree.root}};
    while (count > 0) {
      const auto [a, b] = waiting[--count];
      if (a.is_triangle() && b.is_triangle()) {
        if (!triangles_apart(~a.child, ~b.child)) return false;
        continue;
      }
      const bool splits_a = b.is_triangle() || (!a.is_triangle() && a.box.extent() * scale_ >= b.box.extent());
      const TriangleNode& node = splits_a ? a_.tree.nodes[at(a.child)] : b_.tree.nodes[at(b.child)];
      unsigned left =
          splits_a ? near(node, b.box, &Projected::a, &Projected::b) : near(node, a.box, &Projected::b, &Projected::a);
      for (; left != 0; left &= left - 1) {
        const auto k = static_cast<std::size_t>(__builtin_ctz(left));
        const BoxedNode child = node.boxed(k);
        waiting[count++] = splits_a ? std::pair{child, b} : std::pair{a, child};
      }
    }
    return true;
  }

 private:
  static constexpr std::size_t kMostWaiting = 2 * TriangleTree::kMostLevels * (kTreeWidth - 1) + 1;

  const Solid &a_, &b_;
  const PosedPair* poses_;
  std::size_t count_;
  double limit_;
  float scale_;                               // of lengths in a's units to those in b's
  std::array<Vec3, kDirections> directions_;  // of the frame, of length 1 up to rounding
  std::array<std::array<Projected, kMostPoses>, kDirections> projected_;

  void project(std::size_t k) {
    const Pose& pose = k < 3 ? poses_[0].a : poses_[0].b;
    directions_[k] = unit(poses_[0].frame.from_world(pose.column(k % 3)));
    for (std::size_t p = 0; p < count_; ++p) {
      const Vec3 d = poses_[p].frame.to_world(directions_[k]);
      const Vec3 way = poses_[p].a.apply(a_.tree.middle) - poses_[p].b.apply(b_.tree.middle);
      Projected& out = projected_[k][p];
      out.a = projection(a_, poses_[p].a, d, dot(d, way)), out.b = projection(b_, poses_[p].b, d, 0);
      const double error = (sum_of(out.a) + sum_of(out.b) + limit_) * static_cast<double>(kProjectionError);
      out.limit = static_cast<float>(limit_ + error) * (1 + kProjectionError) + kDenormalFloats;
    }
  }

  // Children of a node that no direction keeps away from a box of the other tree.
  unsigned near(const TriangleNode& node, const OrientedBox& box, Projection Projected::* own,
                Projection Projected::* other) const {
    const LaneBoxes boxes = lane_boxes(node);
    FloatMask apart{};
    for (std::size_t k = 0; k < kDirections; ++k) {
      FloatMask before = ~FloatMask{}, after = before;
      for (std::size_t p = 0; p < count_; ++p) {
        const Projected& at_pose = projected_[k][p];
        const Projection &mine = at_pose.*own, &theirs = at_pose.*other;
        const Floats way = mine.centres(boxes) - theirs.centre(box);
        const Floats room = mine.halves(boxes) + (theirs.half(box) + at_pose.limit);
        before &= way > room, after &= -way > room;
      }
      apart |= before | after;
    }
    return ~bits(apart) & node.all();
  }

  TrianglePoints posed(const Solid& solid, std::int32_t triangle, const Pose& pose) const {
    const MeshTriangle& t = solid.triangles[at(triangle)];
    return {pose.apply(solid.points[at(t[0])]), pose.apply(solid.points[at(t[1])]), pose.apply(solid.points[at(t[2])])};
  }

  bool triangles_apart(std::int32_t triangle_a, std::int32_t triangle_b) {
    std::array<TrianglePoints, kMostPoses> a, b;
    for (std::size_t p = 0; p < count_; ++p)
      a[p] = posed(a_, triangle_a, poses_[p].a), b[p] = posed(b_, triangle_b, poses_[p].b);
    for (const TrianglePoints& t : {a[0], b[0]}) {
      const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
      if (norm_1(normal) > 0 && separates(poses_[0].frame.from_world(unit(normal)), a, b)) return true;
    }
    for (const Vec3& direction : directions_) {
      if (separates(direction, a, b)) return true;
    }
    return ways_separate(a, b);
  }

  // Whether a direction of the frame keeps two triangles apart at all poses, one way or the other.
  bool separates(Vec3 direction, const std::array<TrianglePoints, kMostPoses>& a,
                 const std::array<TrianglePoints, kMostPoses>& b) const {
    bool before = true, after = true;
    for (std::size_t p = 0; p < count_; ++p) {
      const Vec3 d = poses_[p].frame.to_world(direction), from = b[p][0];
      const std::array<double, 3> u{dot(d, a[p][0] - from), dot(d, a[p][1] - from), dot(d, a[p][2] - from)};
      const double v = dot(d, b[p][1] - from), w = dot(d, b[p][2] - from);
      before &= smaller(u[0], smaller(u[1], u[2])) - larger(0, larger(v, w)) > limit_;
      after &= smaller(0, smaller(v, w)) - larger(u[0], larger(u[1], u[2])) > limit_;
    }
    return before || after;
  }

  // The ways between closest points at the poses, and their mean.
  bool ways_separate(const std::array<TrianglePoints, kMostPoses>& a,
                     const std::array<TrianglePoints, kMostPoses>& b) const {
    Vec3 sum;
    for (std::size_t p = 0; p < count_; ++p) {
      const Vec3 way = closest_way(a[p], b[p]);
      const double length = norm(way);
      if (!(length > limit_)) return false;
      const Vec3 direction = poses_[p].frame.from_world((1 / length) * way);
      if (separates(direction, a, b)) return true;
      sum = sum + direction;
    }
    return count_ > 1 && norm_1(sum) > 0 && separates(unit(sum), a, b);
  }
};

}  // namespace

bool solids_further(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit) {
  return Separation(a, b, poses, count, limit).run();
}

}  // namespace plannercheck
