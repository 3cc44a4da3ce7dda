#include "narrow_phase/solid_pair.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "bodies/solid.hpp"
#include "narrow_phase/intersection.hpp"
#include "narrow_phase/tree_frames.hpp"
#include "narrow_phase/triangle_lanes.hpp"
#include "narrow_phase/triangle_pair.hpp"
#include "narrow_phase/winding_number.hpp"

namespace plannercheck {
namespace {

// Half extents of boxes from a tree's units to m, with room for the rounding of their middle.
constexpr double kBoxRoundedUp = 1 + 0x1p-20;

// Places in the tree's units, in doubles: a few u of the place, of the middle and of the box.
constexpr double kPlaceError = 0x1p-48;

// A node or a triangle of a tree, with its box.
struct Below {
  std::int32_t child;
  FloatBox box;

  bool is_triangle() const { return child < 0; }
};

typedef std::array<Below, 2> BelowBoth;

float extent(const FloatBox& box) { return box.half[0] + box.half[1] + box.half[2]; }

// One of the two solids, and the way from its frame to the other one's.
struct SolidSide {
  PosedSolid posed;
  RelativePose to_other;
  TreeMap map;   // between the trees' units
  double error;  // of corners in the other one's frame
  float scale;   // of lengths in its tree's units to those in the other one's

  const TriangleTree& tree() const { return posed.solid->tree; }
  const TriangleNode& node(const Below& below) const { return tree().nodes[at(below.child)]; }

  TriangleCorners in_other(std::int32_t triangle) const {
    const Solid& solid = *posed.solid;
    const MeshTriangle& t = solid.triangles[at(triangle)];
    return {to_other.apply(solid.points[at(t[0])]), to_other.apply(solid.points[at(t[1])]),
            to_other.apply(solid.points[at(t[2])])};
  }
};

SolidSide side_of(const PosedSolid& own, const PosedSolid& other, double reach) {
  const RelativePose to_other(own.pose, other.pose);
  return {own, to_other, tree_map(own, other, to_other, reach), to_other.error(norm_1(own.solid->reach)),
          static_cast<float>(other.solid->tree.units / own.solid->tree.units)};
}

class ContactSearch {
 public:
  ContactSearch(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters, SolidCounters& counted)
      : bodies_{a, b},
        inflation_radius_(a.body->inflation_radius + b.body->inflation_radius),
        sides_{side_of({&a.body->surface(), a.pose}, {&b.body->surface(), b.pose}, inflation_radius_),
               side_of({&b.body->surface(), b.pose}, {&a.body->surface(), a.pose}, inflation_radius_)},
        counters_(counters),
        counted_(counted) {}

  SolidContact run(const SolidContact& guess) {
    if (guess.kind == SolidContact::Kind::kTriangles && at(guess.a) < solid(0).triangles.size() &&
        at(guess.b) < solid(1).triangles.size() && meet({guess.a, guess.b}))
      return guess;
    if (descend()) return {SolidContact::Kind::kTriangles, found_[0], found_[1]};
    return nested();
  }

  SolidContact nested() {
    if (const std::int32_t vertex = vertex_inside(1, 0); vertex >= 0) return {SolidContact::Kind::kAInB, vertex, -1};
    if (const std::int32_t vertex = vertex_inside(0, 1); vertex >= 0) return {SolidContact::Kind::kBInA, -1, vertex};
    return {};
  }

 private:
  // Pairs of nodes that wait: a step down adds a node's children less the one that is taken on.
  static constexpr std::size_t kMostWaiting = 2 * TriangleTree::kMostLevels * (kTreeWidth - 1) + 1;

  typedef std::array<std::int32_t, 2> TrianglePair;

  std::array<PosedPolytope, 2> bodies_;
  double inflation_radius_;
  std::array<SolidSide, 2> sides_;
  PairCounters& counters_;
  SolidCounters& counted_;
  TrianglePair found_{-1, -1};
  std::array<BelowBoth, kMostWaiting> waiting_;
  std::size_t count_ = 0;

  const Solid& solid(std::size_t side) const { return *sides_[side].posed.solid; }

  bool descend() {
    waiting_[count_++] = {Below{0, solid(0).tree.root}, Below{0, solid(1).tree.root}};
    while (count_ > 0) {
      const BelowBoth both = waiting_[--count_];
      if (both[0].is_triangle() ? step_triangle(both, 0) : both[1].is_triangle() ? step_triangle(both, 1) : step(both))
        return true;
    }
    return false;
  }

  // Two nodes: leaves, or the larger one is split.
  bool step(const BelowBoth& both) {
    const TriangleNode &a = sides_[0].node(both[0]), &b = sides_[1].node(both[1]);
    if (a.leaf >= 0 && b.leaf >= 0) return leaves_meet(both, a, b);
    const std::size_t split = extent(both[0].box) * sides_[0].scale >= extent(both[1].box) ? 0 : 1;
    push(split == 0 ? a : b, near(both, split), both, split);
    return false;
  }

  // Children of the node of a side that may meet the other one's box.
  NearChildren near(const BelowBoth& both, std::size_t side) {
    ++counted_.boxes;
    const SolidSide &own = sides_[side], &other = sides_[1 - side];
    const FloatBox& box = both[1 - side].box;
    return children_near(own.node(both[side]), own.map, box, other.map.around(box), own.scale);
  }

  // Pairs of children that wait, the nearest last.
  void push(const TriangleNode& node, const NearChildren& near, const BelowBoth& both, std::size_t side) {
    std::array<float, kTreeWidth> gap;
    std::memcpy(gap.data(), &near.gap, sizeof gap);
    const std::size_t first = count_;
    std::array<float, kTreeWidth> gaps;
    for (unsigned left = near.bits; left != 0; left &= left - 1) {
      const auto k = static_cast<std::size_t>(__builtin_ctz(left));
      if (node.child[k] == TriangleTree::kNothing) continue;
      std::size_t place = count_++ - first;
      for (; place > 0 && gaps[place - 1] < gap[k]; --place) {
        gaps[place] = gaps[place - 1];
        waiting_[first + place][side] = waiting_[first + place - 1][side];
      }
      gaps[place] = gap[k];
      waiting_[count_ - 1][1 - side] = both[1 - side];
      waiting_[first + place][side] = {node.child[k], node.box(k)};
    }
  }

  // A triangle of one side against a node of the other.
  bool step_triangle(const BelowBoth& both, std::size_t side) {
    const SolidSide &own = sides_[side], &other = sides_[1 - side];
    const TriangleNode& node = other.node(both[1 - side]);
    const TriangleCorners corners = own.in_other(~both[side].child);
    if (node.leaf >= 0) return triangle_meets(~both[side].child, corners, side, node, both[1 - side].box);
    ++counted_.boxes;
    const FloatTriangle triangle(corners, own.error, other.tree(), inflation_radius_);
    push(node, triangle.children_near(node), both, 1 - side);
    return false;
  }

  // The near triangles of one leaf against the other one.
  bool leaves_meet(const BelowBoth& both, const TriangleNode& a, const TriangleNode& b) {
    const NearChildren near_a = near(both, 0);
    if (near_a.bits == 0) return false;
    const NearChildren near_b = near(both, 1);
    const std::size_t side = __builtin_popcount(near_a.bits) <= __builtin_popcount(near_b.bits) ? 0 : 1;
    const TriangleNode &from = side == 0 ? a : b, &to = side == 0 ? b : a;
    for (unsigned left = side == 0 ? near_a.bits : near_b.bits; left != 0; left &= left - 1) {
      const std::int32_t child = from.child[static_cast<std::size_t>(__builtin_ctz(left))];
      if (child == TriangleTree::kNothing) continue;
      if (triangle_meets(~child, sides_[side].in_other(~child), side, to, both[1 - side].box)) return true;
    }
    return false;
  }

  // A triangle of one side, its corners in the other one's frame, against a leaf there.
  bool triangle_meets(std::int32_t triangle, const TriangleCorners& corners, std::size_t side, const TriangleNode& node,
                      const FloatBox& box) {
    ++counted_.triangles;
    const TriangleTree& tree = sides_[1 - side].tree();
    const double length = 1 / tree.units;
    const Vec3 middle{tree.middle + length * Vec3{static_cast<double>(box.centre[0]),
                                                  static_cast<double>(box.centre[1]),
                                                  static_cast<double>(box.centre[2])}};
    const Vec3 half =
        length * kBoxRoundedUp *
        Vec3{static_cast<double>(box.half[0]), static_cast<double>(box.half[1]), static_cast<double>(box.half[2])};
    const TriangleLanes lanes = triangle_against(corners, sides_[side].error, tree.leaves[at(node.leaf)], middle, half,
                                                 inflation_radius_ * kFrameStretch);
    const auto pair = [&](unsigned bit) {
      const std::int32_t other = ~node.child[static_cast<std::size_t>(__builtin_ctz(bit))];
      return side == 0 ? TrianglePair{triangle, other} : TrianglePair{other, triangle};
    };
    if (lanes.meet != 0) {
      found_ = pair(lanes.meet);
      return true;
    }
    for (unsigned left = lanes.open; left != 0; left &= left - 1) {
      found_ = pair(left);
      if (meet_exactly(found_)) return true;
    }
    return false;
  }

  bool meet(TrianglePair triangles) {
    ++counted_.triangles;
    const TriangleCorners a = sides_[0].in_other(triangles[0]);
    const MeshTriangle& t = solid(1).triangles[at(triangles[1])];
    const std::vector<Vec3>& points = solid(1).points;
    const TriangleAnswer answer =
        triangles_meet(a, {points[at(t[0])], points[at(t[1])], points[at(t[2])]}, sides_[0].error);
    if (answer == TriangleAnswer::kMeet) return true;
    if (answer == TriangleAnswer::kApart && inflation_radius_ == 0) return false;
    return meet_exactly(triangles);
  }

  bool meet_exactly(TrianglePair triangles) {
    ++counted_.exact;
    const Polytope a = triangle_body(solid(0), triangles[0], bodies_[0]);
    const Polytope b = triangle_body(solid(1), triangles[1], bodies_[1]);
    return test_pair({&a, bodies_[0].pose}, {&b, bodies_[1].pose}, {}, nullptr, counters_).shared;
  }

  static Polytope triangle_body(const Solid& solid, std::int32_t triangle, const PosedPolytope& of) {
    const MeshTriangle& t = solid.triangles[at(triangle)];
    Polytope body = prepare_polytope({solid.points[at(t[0])], solid.points[at(t[1])], solid.points[at(t[2])]});
    body.inflation_radius = of.body->inflation_radius;
    return body;
  }

  // A vertex around which a closed solid winds, of those that stand for parts of another one; or −1.
  std::int32_t vertex_inside(std::size_t outer_side, std::size_t inner_side) {
    const PosedSolid &around = sides_[outer_side].posed, &inner = sides_[inner_side].posed;
    if (!around.solid->is_closed) return -1;
    for (std::size_t k = 0; k < inner.solid->components.size(); ++k) {
      if (reaches_out(inner_side, inner.solid->extremes[k])) continue;
      ++counted_.points;
      const std::int32_t vertex = inner.solid->components[k];
      if (winding_number(around, inner.pose, inner.solid->points[at(vertex)]) != 0) return vertex;
    }
    return -1;
  }

  // Whether one of some vertices of a side is surely outside of the box around the other solid: then nothing winds
  // around it, nor around any point of the part that it belongs to.
  bool reaches_out(std::size_t side, const std::array<std::int32_t, 6>& vertices) const {
    const SolidSide& own = sides_[side];
    const TriangleTree& around = sides_[1 - side].tree();
    for (const std::int32_t vertex : vertices) {
      const Vec3 place = around.units * (own.to_other.apply(solid(side).points[at(vertex)]) - around.middle);
      const double room = around.units * own.error + (1 + norm_max(place)) * kPlaceError;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double beyond = std::fabs(place[static_cast<int>(axis)] - static_cast<double>(around.root.centre[axis]));
        if (beyond > static_cast<double>(around.root.half[axis]) + room) return true;
      }
    }
    return false;
  }
};

}  // namespace

SolidContact solids_contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                            PairCounters& counters, SolidCounters* counted) {
  SolidCounters own;
  return ContactSearch(a, b, counters, counted == nullptr ? own : *counted).run(guess);
}

bool are_nested(const PosedPolytope& a, const PosedPolytope& b) {
  PairCounters counters;
  SolidCounters counted;
  return static_cast<bool>(ContactSearch(a, b, counters, counted).nested());
}

}  // namespace plannercheck
