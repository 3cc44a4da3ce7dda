#include "narrow_phase/solid_pair.hpp"

#include <array>
#include <utility>

#include "bodies/solid.hpp"
#include "narrow_phase/intersection.hpp"
#include "narrow_phase/tree_frames.hpp"
#include "narrow_phase/triangle_pair.hpp"
#include "narrow_phase/winding_number.hpp"

namespace plannercheck {
namespace {

// A node or a triangle of a tree, with its box.
struct Below {
  std::int32_t child;
  FloatBox box;

  bool is_triangle() const { return child < 0; }
};

float extent(const FloatBox& box) { return box.half[0] + box.half[1] + box.half[2]; }

class ContactSearch {
 public:
  ContactSearch(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters, SolidCounters& counted)
      : body_a_(a),
        body_b_(b),
        a_{&a.body->surface(), a.pose},
        b_{&b.body->surface(), b.pose},
        inflation_radius_(a.body->inflation_radius + b.body->inflation_radius),
        frames_(a_, b_, inflation_radius_),
        corner_error_(kCornerError * larger(posing_magnitude(a_), posing_magnitude(b_)) + kDenormalError),
        counters_(counters),
        counted_(counted) {}

  SolidContact run(const SolidContact& guess) {
    if (guess.kind == SolidContact::Kind::kTriangles && at(guess.a) < a_.solid->triangles.size() &&
        at(guess.b) < b_.solid->triangles.size() && meet(guess.a, guess.b))
      return guess;
    if (const SolidContact found = descend()) return found;
    if (const std::int32_t vertex = vertex_inside(b_, a_); vertex >= 0) return {SolidContact::Kind::kAInB, vertex, -1};
    if (const std::int32_t vertex = vertex_inside(a_, b_); vertex >= 0) return {SolidContact::Kind::kBInA, -1, vertex};
    return {};
  }

 private:
  // Pairs of nodes that wait: a step down adds a node's children less the one that is taken on.
  static constexpr std::size_t kMostWaiting = 2 * TriangleTree::kMostLevels * (kTreeWidth - 1) + 1;

  PosedPolytope body_a_, body_b_;
  PosedSolid a_, b_;
  double inflation_radius_;
  TreeFrames frames_;
  double corner_error_;
  PairCounters& counters_;
  SolidCounters& counted_;

  SolidContact descend() {
    std::array<std::pair<Below, Below>, kMostWaiting> waiting;
    std::size_t count = 0;
    waiting[count++] = {{0, a_.solid->tree.root}, {0, b_.solid->tree.root}};
    while (count > 0) {
      const auto [a, b] = waiting[--count];
      if (a.is_triangle() && b.is_triangle()) {
        if (meet(~a.child, ~b.child)) return {SolidContact::Kind::kTriangles, ~a.child, ~b.child};
        continue;
      }
      ++counted_.boxes;
      const FloatBox a_in_b = frames_.a_to_b().around(a.box), b_in_a = frames_.b_to_a().around(b.box);
      const bool splits_a = b.is_triangle() || (!a.is_triangle() && extent(a_in_b) >= extent(b.box));
      const TriangleNode& node = splits_a ? a_.solid->tree.nodes[at(a.child)] : b_.solid->tree.nodes[at(b.child)];
      unsigned near = splits_a ? children_near(node, frames_.a_to_b(), b.box, b_in_a)
                               : children_near(node, frames_.b_to_a(), a.box, a_in_b);
      for (; near != 0; near &= near - 1) {
        const auto k = static_cast<std::size_t>(__builtin_ctz(near));
        if (node.child[k] == TriangleTree::kNothing) continue;
        const Below child{node.child[k], node.box(k)};
        waiting[count++] = splits_a ? std::pair{child, b} : std::pair{a, child};
      }
    }
    return {};
  }

  bool meet(std::int32_t triangle_a, std::int32_t triangle_b) {
    ++counted_.triangles;
    if (inflation_radius_ == 0) {
      const Corners a{a_.corner(triangle_a, 0), a_.corner(triangle_a, 1), a_.corner(triangle_a, 2)};
      const Corners b{b_.corner(triangle_b, 0), b_.corner(triangle_b, 1), b_.corner(triangle_b, 2)};
      const TriangleAnswer answer = triangles_meet(a, b, corner_error_);
      if (answer != TriangleAnswer::kOpen) return answer == TriangleAnswer::kMeet;
    }
    ++counted_.exact;
    const Polytope a = triangle_body(*a_.solid, triangle_a, body_a_), b = triangle_body(*b_.solid, triangle_b, body_b_);
    return test_pair({&a, a_.pose}, {&b, b_.pose}, {}, nullptr, counters_).shared;
  }

  static Polytope triangle_body(const Solid& solid, std::int32_t triangle, const PosedPolytope& of) {
    const MeshTriangle& t = solid.triangles[at(triangle)];
    Polytope body = prepare_polytope({solid.points[at(t[0])], solid.points[at(t[1])], solid.points[at(t[2])]});
    body.inflation_radius = of.body->inflation_radius;
    return body;
  }

  // A vertex around which a closed solid winds, of those that stand for parts of another one; or −1.
  std::int32_t vertex_inside(const PosedSolid& around, const PosedSolid& inner) {
    if (!around.solid->is_closed) return -1;
    for (const std::int32_t vertex : inner.solid->components) {
      ++counted_.points;
      if (winding_number(around, inner.pose, inner.solid->points[at(vertex)]) != 0) return vertex;
    }
    return -1;
  }
};

}  // namespace

SolidContact solids_contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                            PairCounters& counters, SolidCounters* counted) {
  SolidCounters own;
  return ContactSearch(a, b, counters, counted == nullptr ? own : *counted).run(guess);
}

}  // namespace plannercheck
