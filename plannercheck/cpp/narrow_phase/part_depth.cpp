#include "narrow_phase/part_depth.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "bodies/lane_boxes.hpp"
#include "bodies/part_body.hpp"
#include "bodies/solid_interior.hpp"
#include "math/predicates.hpp"
#include "narrow_phase/minkowski_difference.hpp"
#include "narrow_phase/pair_kernels.hpp"
#include "narrow_phase/part_walk.hpp"
#include "narrow_phase/posed_solid.hpp"

namespace plannercheck {
namespace {

// A translation that leaves a part at contact is longer by so many bounds of the rounding of the pair's heights.
constexpr double kBeyondContact = 8;

// Bisections end at this part of the smaller body's size.
constexpr double kExitStep = 1e-10;

// A length inside of a body's frame, which is off rigid by at most 3.6e-6, is at least so long in the world.
constexpr double kInWorld = 1 - 1e-5;

// Room for rounding where triangles are sought, of floats in a tree's units; what it misses is a piece less.
constexpr float kNearRoom = 0x1p-18F;

// A solid's shells are judged if this takes no more signs of determinants: a few milliseconds.
constexpr std::size_t kMostSigns = 400'000;

// ----- a solid's shells

// The triangles of each part of a mesh that hangs together by vertices.
std::vector<std::vector<MeshTriangle>> shells_of(const Solid& solid) {
  std::vector<std::int32_t> parent(solid.points.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t v) {
    while (parent[at(v)] != v) v = parent[at(v)] = parent[at(parent[at(v)])];
    return v;
  };
  for (const MeshTriangle& t : solid.triangles) parent[at(root(t[1]))] = parent[at(root(t[2]))] = root(t[0]);
  std::vector<std::int32_t> place(solid.points.size(), -1);
  std::vector<std::vector<MeshTriangle>> out;
  for (const MeshTriangle& t : solid.triangles) {
    std::int32_t& shell = place[at(root(t[0]))];
    if (shell < 0) shell = static_cast<std::int32_t>(out.size()), out.emplace_back();
    out[at(shell)].push_back(t);
  }
  return out;
}

// The side of all triangles on which all vertices of a shell are, 1 or −1; 0 if there is none. A closed shell with a
// side is the boundary of its hull: each triangle is in that, and all turn the same way around the inside.
int common_side(const std::vector<MeshTriangle>& shell, const std::vector<Vec3>& all,
                const std::vector<Vec3>& vertices) {
  int side = 0;
  for (const MeshTriangle& t : shell) {
    for (const Vec3& v : vertices) {
      const int sign = orientation(all[at(t[0])], all[at(t[1])], all[at(t[2])], v);
      if (sign * side < 0) return 0;
      if (sign != 0) side = sign;
    }
  }
  return side;
}

// The shells of a closed solid as bodies if all are convex and wind alike, so that their hulls' union is the solid.
std::vector<Polytope> convex_shells(const Solid& solid, double inflation_radius) {
  std::vector<Polytope> out;
  if (!solid.is_closed) return out;
  std::size_t signs = 0;
  int all_sides = 0;
  for (const std::vector<MeshTriangle>& shell : shells_of(solid)) {
    std::vector<std::int32_t> used;
    for (const MeshTriangle& t : shell) used.insert(used.end(), t.begin(), t.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    signs += used.size() * shell.size();
    if (signs > kMostSigns) return {};
    std::vector<Vec3> vertices;
    for (const std::int32_t v : used) vertices.push_back(solid.points[at(v)]);
    const int side = common_side(shell, solid.points, vertices);
    if (side == 0 || side * all_sides < 0) return {};
    all_sides = side;
    out.push_back(prepare_polytope(vertices));
    out.back().inflation_radius = inflation_radius;
  }
  return out;
}

// ----- pieces of a body

PartShape rounded_box(const InnerBox& box) {
  PartShape out;
  out.corners = 8, out.radius = box.radius * kInWorld;
  for (std::size_t c = 0; c < 8; ++c) {
    out.corner[c] = {c & 1 ? box.high.x : box.low.x, c & 2 ? box.high.y : box.low.y, c & 4 ? box.high.z : box.low.z};
  }
  return out;
}

PartShape ball_shape(Vec3 centre, double radius) { return {{centre}, 1, radius * kInWorld}; }

// Convex bodies that are in a body, one at a time.
class Pieces {
 public:
  explicit Pieces(const PosedPolytope& body) : body_(body) {
    if (is_solid()) shells_ = convex_shells(solid(), body.body->inflation_radius);
  }

  // Calls visit(piece) for those that may share a point with another body.
  template <class Visit>
  void each_near(const PosedPolytope& other, Visit visit) {
    if (is_solid()) {
      each_of_solid(other, visit);
    } else if (body_.body->traits().has_parts) {
      each_part(other, visit);
    } else {
      visit(body_);
    }
  }

 private:
  const PosedPolytope& body_;
  std::vector<Polytope> shells_;
  PartBody filled_;

  bool is_solid() const { return body_.body->kind() == Kind::kSolid; }
  const Solid& solid() const { return body_.body->surface(); }

  template <class Visit>
  void show(const PartShape& shape, Visit visit) {
    filled_.fill(shape, body_.body->inflation_radius);
    visit(PosedPolytope{&filled_.body(), body_.pose});
  }

  template <class Visit>
  void each_part(const PosedPolytope& other, Visit visit) {
    const PartSet& parts = body_.body->as<PartSet>();
    PartWalk walk(other, body_, body_.body->inflation_radius + other.body->inflation_radius);
    walk.any_leaf([&](std::size_t leaf, unsigned near) {
      for (; near != 0; near &= near - 1) {
        const PartShape shape = parts.shape(leaf * kPartsInLeaf + static_cast<std::size_t>(__builtin_ctz(near)));
        if (shape.corners != 0) show(shape, visit);
      }
      return false;
    });
  }

  template <class Visit>
  void each_of_solid(const PosedPolytope& other, Visit visit) {
    for (const Polytope& shell : shells_) visit(PosedPolytope{&shell, body_.pose});
    if (!shells_.empty()) return;
    const InversePose to_frame(body_.pose);
    const InnerShapes& inner = body_.body->inner_shapes();
    if (inner.box) show(rounded_box(*inner.box), visit);
    for (const InnerBall& one : inner.balls) show(ball_shape(one.centre, one.radius), visit);
    const Vec3 vertex = to_frame.apply(other.pose.apply(other.body->inner.points.front()));
    if (const double radius = inner_radius(solid(), vertex); radius > 0) show(ball_shape(vertex, radius), visit);
    const double reach = extent(*other.body) + body_.body->inflation_radius;
    each_triangle(to_frame.apply(other.pose.apply(other.body->centre)), reach, visit);
  }

  // The triangles whose boxes are within a reach of a point.
  template <class Visit>
  void each_triangle(Vec3 middle, double reach, Visit visit) {
    const TriangleTree& tree = solid().tree;
    const Vec3 place = tree.units * (middle - tree.middle);
    const auto room = static_cast<float>(tree.units * reach) * (1 + kNearRoom) + kNearRoom;
    const std::array<float, 3> from{static_cast<float>(place.x), static_cast<float>(place.y),
                                    static_cast<float>(place.z)};
    any_triangle(
        tree, [&](const TriangleNode& node) { return children_within(node, from, {room, room, room}); },
        [&](std::int32_t triangle) {
          const std::array<Vec3, 3> t = tree.corners(triangle);
          show({{t[0], t[1], t[2]}, t.size(), 0}, visit);
          return false;
        });
  }
};

// ----- the depth

class PieceDepth {
 public:
  // `found`: that of pair_distance, where the bodies overlap.
  PieceDepth(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairDistance& found,
             PairCounters& counters)
      : body_a_(body_a), body_b_(body_b), counters_(counters), found_(found) {}

  PairDistance run() {
    find_deepest();
    if (!ways_.empty() && leaves_by(ways_.back(), exit_ + error_)) return found_;
    ways_.push_back(found_.direction);
    for (const PosedPolytope* body : {&body_a_, &body_b_}) {
      for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        const Vec3 way = unit(body->pose.rotate(axis));
        ways_.push_back(way), ways_.push_back(-way);
      }
    }
    for (const Vec3 way : ways_) shorten(way);
    found_.on_body_b = found_.on_body_a + most() * found_.direction;
    return found_;
  }

 private:
  const PosedPolytope &body_a_, &body_b_;
  PairCounters& counters_;
  PairDistance found_;
  std::vector<Vec3> ways_;  // out of pairs of pieces, of which each was the deepest so far
  double exit_ = 0;         // of the last pair
  double error_ = kBeyondContact * MinkowskiDifference(body_a_, body_b_, counters_).support_error();

  double least() const { return -found_.upper; }  // no translation shorter than this separates the bodies
  double most() const { return -found_.lower; }

  void find_deepest() {
    Pieces of_a(body_a_), of_b(body_b_);
    of_a.each_near(body_b_, [&](const PosedPolytope& a) {
      if (ball_gap(a, body_b_) < found_.upper) of_b.each_near(a, [&](const PosedPolytope& b) { take(a, b); });
    });
  }

  void take(const PosedPolytope& a, const PosedPolytope& b) {
    if (!(ball_gap(a, b) < found_.upper)) return;  // no deeper: the balls around them are not
    const PairDistance pair = convex_distance(a, b, 0, counters_);
    if (!pair.overlap || !(pair.upper < found_.upper)) return;
    found_.upper = pair.upper, found_.on_body_a = pair.on_body_a, exit_ = -pair.lower;
    ways_.push_back(pair.direction);
  }

  // Whether a translation by about a length separates the bodies, and is shorter than those that do so far; then it is
  // what is found.
  bool leaves_by(Vec3 way, double length) {
    PosedPolytope moved = body_a_;
    moved.pose.m[3] += length * way.x, moved.pose.m[7] += length * way.y, moved.pose.m[11] += length * way.z;
    const double by = norm_above(moved.pose.translation() - body_a_.pose.translation());
    if (!(by < most()) || share_a_point(moved, body_b_, {}, counters_)) return false;
    found_.lower = -by, found_.direction = way, found_.on_body_b = found_.on_body_a + by * way;
    return true;
  }

  void shorten(Vec3 way) {
    const double step = kExitStep * smaller(extent(*body_a_.body), extent(*body_b_.body));
    double shared = least(), apart = most() - step;
    if (!leaves_by(way, apart)) return;
    while (apart - shared > step) {
      const double middle = shared + 0.5 * (apart - shared);
      (leaves_by(way, middle) ? apart : shared) = middle;
    }
  }
};

}  // namespace

PairDistance signed_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters) {
  const PairDistance found = pair_distance(body_a, body_b, kNoLimit, counters);
  const Kind kind = kind_of(*body_a.body, *body_b.body);
  if (!found.overlap || kind == Kind::kHull || kind == Kind::kHalfSpace) return found;
  return PieceDepth(body_a, body_b, found, counters).run();
}

}  // namespace plannercheck
