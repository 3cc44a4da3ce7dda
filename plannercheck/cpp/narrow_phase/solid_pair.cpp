#include "narrow_phase/solid_pair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "bodies/part_body.hpp"
#include "bodies/solid.hpp"
#include "narrow_phase/intersection.hpp"
#include "narrow_phase/solid_side.hpp"
#include "narrow_phase/tree_frames.hpp"
#include "narrow_phase/triangle_lanes.hpp"
#include "narrow_phase/triangle_pair.hpp"
#include "narrow_phase/winding_number.hpp"

namespace plannercheck {
namespace {

// Places in the tree's units, in doubles: a few u of the place, of the middle and of the box.
constexpr double kPlaceError = 0x1p-48;

class ContactSearch {
 public:
  ContactSearch(const PosedPolytope& a, const PosedPolytope& b, const SolidOptions& options, PairCounters& counters,
                SolidCounters& counted)
      : bodies_{a, b},
        inflation_radius_(a.body->inflation_radius + b.body->inflation_radius),
        sides_{SolidSide{{&a.body->surface(), a.pose}, {&b.body->surface(), b.pose}, inflation_radius_},
               SolidSide{{&b.body->surface(), b.pose}, {&a.body->surface(), a.pose}, inflation_radius_}},
        options_(options),
        counters_(counters),
        counted_(counted) {}

  SolidContact run(const SolidContact& guess) {
    if (guess.kind == SolidContact::Kind::kTriangles && at(guess.a) < solid(0).triangles.size() &&
        at(guess.b) < solid(1).triangles.size() && meet({guess.a, guess.b}))
      return guess;
    if (descend()) return {SolidContact::Kind::kTriangles, found_[0], found_[1]};
    return hulls_share_ == false ? SolidContact{} : nested();
  }

  // The same if it is not known whether the hulls meet: they are tested if the trees do not decide soon.
  SolidContact run(const SolidContact& guess, HullTest& hulls, int patience) {
    hulls_ = &hulls, patience_ = patience;
    return run(guess);
  }

  // Whether the hulls share a point, as far as that was asked or follows.
  std::optional<bool> hulls_share() const { return hulls_share_; }

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
  SolidOptions options_;
  PairCounters& counters_;
  SolidCounters& counted_;
  std::array<Below, 2> mapped_{Below{0, -2, 0, 0}, Below{0, -2, 0, 0}};  // whose boxes are abroad
  std::array<BoxAbroad, 2> abroad_;
  HullTest* hulls_ = nullptr;
  int patience_ = 0;
  std::optional<bool> hulls_share_;
  TrianglePair found_{-1, -1};
  std::array<BelowBoth, kMostWaiting> waiting_;
  std::size_t count_ = 0;

  const Solid& solid(std::size_t side) const { return *sides_[side].posed.solid; }

  // Down from the roots, always to the nearest pair of children first.
  bool descend() {
    BelowBoth both{sides_[0].root(), sides_[1].root()};
    for (int steps = 0;; ++steps) {
      if (steps == patience_ && hulls_ != nullptr) {
        hulls_share_ = hulls_->share();
        if (!*hulls_share_) return false;
      }
      const std::array<bool, 2> is_end{sides_[0].is_end(both[0]), sides_[1].is_end(both[1])};
      if (is_end[0] && is_end[1]) {
        if (ends_meet(both)) return true;
      } else if (split(both)) {
        continue;
      }
      if (count_ == 0) return false;
      both = waiting_[--count_];
    }
  }

  // Takes the larger one's children in its place that are near the other one: the nearest now, others later. False if
  // none is near. A triangle is never split.
  bool split(BelowBoth& both) {
    const bool splits_first =
        both[1].is_triangle() || (!both[0].is_triangle() && both[0].extent * sides_[0].map.scale() >= both[1].extent);
    const std::size_t side = splits_first ? 0 : 1;
    const NearChildren found = near(both, side);
    if (found.bits == 0) return false;
    const ChildrenBelow children(sides_[side].node(both[side]), both[side].child);
    const auto nearest = options_.nearest_first ? nearest_of(found) : static_cast<unsigned>(__builtin_ctz(found.bits));
    const TriangleNode* const nodes = children.are_nodes() ? sides_[side].tree().nodes.data() : nullptr;
    both[side] = children[nearest];
    if (nodes != nullptr) bring(nodes[both[side].child]);
    for (unsigned left = found.bits & ~(1U << nearest); left != 0; left &= left - 1) {
      BelowBoth& waiting = waiting_[count_++];
      waiting[1 - side] = both[1 - side];
      waiting[side] = children[static_cast<unsigned>(__builtin_ctz(left))];
      if (nodes != nullptr) bring(nodes[waiting[side].child]);
    }
    return true;
  }

  // Children of the node of a side that may meet the other one's box.
  NearChildren near(const BelowBoth& both, std::size_t side) {
    ++counted_.boxes;
    const TriangleNode& node = sides_[side].node(both[side]);
    const std::size_t other = 1 - side;
    if (!options_.boxes) return {node.all(), Floats{}};
    if (!mapped_[other].has_box_of(both[other])) {
      mapped_[other] = both[other];
      sides_[other].map.put_abroad(sides_[other].box(both[other]), abroad_[other]);
    }
    return children_near(node, abroad_[other]);
  }

  // Two leaves, two triangles, or one of each.
  bool ends_meet(const BelowBoth& both) {
    if (both[0].is_triangle() && both[1].is_triangle()) {
      found_ = {~both[0].child, ~both[1].child};
      return meet(found_);
    }
    if (both[0].is_triangle()) return triangle_meets(~both[0].child, 0, sides_[1].node(both[1]));
    if (both[1].is_triangle()) return triangle_meets(~both[1].child, 1, sides_[0].node(both[0]));
    return leaves_meet(both);
  }

  // The near triangles of one leaf against the other one.
  bool leaves_meet(const BelowBoth& both) {
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}})
      bring(sides_[side].tree().leaves[at(sides_[side].node(both[side]).leaf)]);
    const NearChildren near_a = near(both, 0);
    if (near_a.bits == 0) return false;
    const bool is_one = (near_a.bits & (near_a.bits - 1)) == 0;
    const NearChildren near_b = is_one ? near_a : near(both, 1);
    const std::size_t side = __builtin_popcount(near_a.bits) <= __builtin_popcount(near_b.bits) ? 0 : 1;
    const TriangleNode &from = sides_[side].node(both[side]), &to = sides_[1 - side].node(both[1 - side]);
    for (unsigned left = side == 0 ? near_a.bits : near_b.bits; left != 0; left &= left - 1) {
      const std::int32_t child = from.child(static_cast<std::size_t>(__builtin_ctz(left)));
      if (triangle_meets(~child, side, to)) return true;
    }
    return false;
  }

  // A triangle of one side against a leaf of the other one.
  bool triangle_meets(std::int32_t triangle, std::size_t side, const TriangleNode& leaf) {
    ++counted_.triangles;
    const SolidSide& other = sides_[1 - side];
    const TriangleCorners corners = sides_[side].in_other(triangle);
    TriangleLanes lanes{0, leaf.all()};
    if (options_.lanes) {
      lanes = triangle_against(corners, sides_[side].error, other.tree().leaves[at(leaf.leaf)], leaf.children,
                               other.spread(leaf, corners), inflation_radius_ * kFrameStretch);
    }
    const auto pair = [&](unsigned bit) {
      const std::int32_t met = ~leaf.child(static_cast<std::size_t>(__builtin_ctz(bit)));
      return side == 0 ? TrianglePair{triangle, met} : TrianglePair{met, triangle};
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
    const TriangleAnswer answer = triangles_meet(a, sides_[1].tree().corners(triangles[1]), sides_[0].error);
    if (answer == TriangleAnswer::kMeet) return true;
    if (answer == TriangleAnswer::kApart && inflation_radius_ == 0) return false;
    return meet_exactly(triangles);
  }

  bool meet_exactly(TrianglePair triangles) {
    ++counted_.exact;
    thread_local std::array<PartBody, 2> filled;
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const TriangleCorners t = solid(side).tree.corners(triangles[side]);
      filled[side].fill({{t[0], t[1], t[2]}, t.size(), 0}, bodies_[side].body->inflation_radius);
    }
    const PosedPolytope a{&filled[0].body(), bodies_[0].pose}, b{&filled[1].body(), bodies_[1].pose};
    return test_pair(a, b, {}, nullptr, counters_).shared;
  }

  // A vertex around which a closed solid winds, of those that stand for parts of another one; or −1.
  std::int32_t vertex_inside(std::size_t outer_side, std::size_t inner_side) {
    const PosedSolid &around = sides_[outer_side].posed, &inner = sides_[inner_side].posed;
    if (!around.solid->is_closed) return -1;
    for (std::size_t k = 0; k < inner.solid->components.size(); ++k) {
      if (options_.reaching_out && reaches_out(inner_side, inner.solid->extremes[k])) continue;
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
    const TriangleTree& tree = sides_[1 - side].tree();
    const AlignedBox box = around(tree.root);
    for (const std::int32_t vertex : vertices) {
      const Vec3 place = tree.units * (own.to_other.apply(solid(side).points[at(vertex)]) - tree.middle);
      const double room = tree.units * own.error + (1 + norm_max(place)) * kPlaceError;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double beyond = std::fabs(place[axis] - static_cast<double>(box.centre[axis]));
        if (beyond > static_cast<double>(box.half[axis]) + room) return true;
      }
    }
    return false;
  }
};

}  // namespace

SolidContact triangles_contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                               PairCounters& counters, const SolidOptions& options, SolidCounters* counted) {
  SolidCounters own;
  return ContactSearch(a, b, options, counters, counted == nullptr ? own : *counted).run(guess);
}

bool solids_share_with(const PosedPolytope& a, const PosedPolytope& b, HullTest& hulls, bool trees_first,
                       SolidHistory& history, PairCounters& counters) {
  SolidContact found;
  if (equal_their_hulls(a, b)) {
    if (!hulls.share()) return false;
    if (hulls.settled()) return true;
    found = triangles_contact(a, b, history.contact, counters);
  } else if (trees_first && history.hulls_met) {
    SolidCounters counted;
    ContactSearch search(a, b, {}, counters, counted);
    found = search.run(history.contact, hulls, history.patience);
    const std::optional<bool> told = search.hulls_share();
    history.hulls_met = told.value_or(found || !history.wants_plane);
    if (told) {
      history.patience =
          *told ? std::min(2 * history.patience, SolidHistory::kMostPatience) : SolidHistory::kLeastPatience;
    }
  } else {
    history.hulls_met = hulls.share();
    if (history.hulls_met) found = triangles_contact(a, b, history.contact, counters);
  }
  if (found) history.contact = found;
  return static_cast<bool>(found);
}

bool are_nested(const PosedPolytope& a, const PosedPolytope& b) {
  PairCounters counters;
  SolidCounters counted;
  return static_cast<bool>(ContactSearch(a, b, {}, counters, counted).nested());
}

}  // namespace plannercheck
