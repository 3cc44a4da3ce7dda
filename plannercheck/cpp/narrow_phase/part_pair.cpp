#include "narrow_phase/part_pair.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <queue>
#include <vector>

#include "bodies/part_body.hpp"
#include "narrow_phase/intersection.hpp"
#include "narrow_phase/part_walk.hpp"
#include "narrow_phase/points_near_hull.hpp"
#include "narrow_phase/solid_pair.hpp"

namespace plannercheck {
namespace {

// Gaps are lengths in a frame, which is off rigid by 3.6e-6 at most, and are rounded to floats.
constexpr double kPartGapRounding = 1 - 1e-5;

// The sides of a node's box in its set's frame err by less than these parts of the set's middle, and of a unit.
constexpr double kNodeMiddleError = 0x1p-50, kNodeUnitError = 0x1p-48;

// Reused for each part, because a million parts are tested a second.
struct PartBodies {
  PartBody a, b;
};

PartBodies& part_bodies() {
  thread_local PartBodies bodies;
  return bodies;
}

PairVerdict convex_contact(const PosedPolytope& part, const PosedPolytope& body, PairCounters& counters) {
  const bool indices_b = choose_b(*part.body, *body.body) == 1;
  return indices_b ? test_pair(part, body, {}, nullptr, counters) : test_pair(body, part, {}, nullptr, counters);
}

// Whether one part, posed as its set, shares a point with a body that is no set.
bool part_meets(const PartShape& shape, const PosedPolytope& set, const PosedPolytope& body, PartBody& filled,
                PairCounters& counters) {
  filled.fill(shape, set.body->inflation_radius);
  const PairVerdict hulls = convex_contact({&filled.body(), set.pose}, body, counters);
  if (!hulls.shared || hulls.settles) return hulls.shared;
  const Polytope part = polytope_of(shape, set.body->inflation_radius);
  return static_cast<bool>(triangles_contact({&part, set.pose}, body, {}, counters));
}

// The balls of leaves against one hull, eight at once.
class BallsOfLeaves {
 public:
  BallsOfLeaves(const PosedPolytope& set, const PosedPolytope& body) : set_(set), hull_(body, set.pose) {}

  // The balls of a leaf that share a point with the hull, a bit each.
  unsigned met(std::size_t leaf, PairCounters& counters) {
    static_assert(kPartsInLeaf == kMostPoints);
    const PartSet& parts = set_.body->as<PartSet>();
    const EightPoints& points = parts.points(leaf);
    const std::size_t first = leaf * kPartsInLeaf, count = std::min(kPartsInLeaf, parts.part_count() - first);
    std::array<double, kPartsInLeaf> radii;
    for (std::size_t k = 0; k < kPartsInLeaf; ++k) radii[k] = parts.radius(first + k) + set_.body->inflation_radius;
    return hull_.near(points.x.data(), points.y.data(), points.z.data(), radii.data(), static_cast<int>(count),
                      counters);
  }
  Vec3 beyond() const { return hull_.beyond(); }

 private:
  const PosedPolytope& set_;
  PointsNearHull hull_;
};

// The place of a part that shares a point with a body that is no set, or −1. `inner`: see PartWalk.
std::int32_t place_met(const PosedPolytope& set, const PosedPolytope& body, const InnerBall* inner, std::int32_t guess,
                       PairCounters& counters) {
  const PartSet& parts = set.body->as<PartSet>();
  PartBody& filled = part_bodies().a;
  PartWalk walk(body, set, set.body->inflation_radius + body.body->inflation_radius, inner);
  const bool is_hull = body.body->traits().fills_hull();
  const bool are_balls = parts.kind() == PartSet::Kind::kBalls && is_hull;
  std::optional<BallsOfLeaves> balls;  // made when it is first needed
  std::int32_t met = -1;
  const auto found = [&](std::size_t place) { return met = static_cast<std::int32_t>(place), true; };
  const auto meets = [&](std::size_t leaf, unsigned near) {
    const std::size_t first = leaf * kPartsInLeaf;
    if (are_balls && near != 0) {
      unsigned shared = walk.surely_shared(leaf) & near;
      if (shared == 0) {
        if (!balls) balls.emplace(set, body);
        shared = balls->met(leaf, counters);
        if (shared == 0) walk.leave_out_beyond(balls->beyond(), counters);
      }
      return shared != 0 && found(first + static_cast<std::size_t>(__builtin_ctz(shared)));
    }
    for (; near != 0; near &= near - 1) {
      const std::size_t place = first + static_cast<std::size_t>(__builtin_ctz(near));
      const PartShape shape = parts.shape(place);
      if (shape.corners == 0) continue;
      if ((is_hull && walk.surely_shares(shape)) || part_meets(shape, set, body, filled, counters)) return found(place);
    }
    return false;
  };
  if (guess >= 0 && at(guess) < parts.leaf_count() * kPartsInLeaf) {
    const std::size_t leaf = at(guess) / kPartsInLeaf;
    if (meets(leaf, walk.near_in_leaf(leaf) & 1U << at(guess) % kPartsInLeaf)) return met;
  }
  walk.any_leaf(meets);
  return met;
}

// As place_met, but without the tree and the body's inner shapes: each part takes the test of pairs.
std::int32_t first_place_met(const PosedPolytope& set, const PosedPolytope& body, PairCounters& counters) {
  const PartSet& parts = set.body->as<PartSet>();
  PartBody& filled = part_bodies().a;
  std::int32_t met = -1;
  parts.any_part([&](const PartShape& part, std::size_t place) {
    if (part_meets(part, set, body, filled, counters)) met = static_cast<std::int32_t>(place);
    return met >= 0;
  });
  return met;
}

// A node's child as a box in its set's frame, with room for rounding.
PartShape box_of(const PartSet& set, const PartNode& node, std::size_t child) {
  PartShape box;
  std::array<std::array<double, 2>, 3> side;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto centre = static_cast<double>(node.centre[i][child]), half = static_cast<double>(node.half[i][child]);
    if (!(half >= 0)) return box;
    const double middle = set.middle()[i], units = set.units();
    const double room = std::fabs(middle) * kNodeMiddleError + kNodeUnitError / units;
    side[i] = {middle + (centre - half) / units - room, middle + (centre + half) / units + room};
  }
  box.corners = 8;
  for (std::size_t c = 0; c < 8; ++c) box.corner[c] = {side[0][c & 1], side[1][c >> 1 & 1], side[2][c >> 2]};
  return box;
}

// Two sets: boxes of the smaller one's tree are followed down the other's, then its parts.
class SetsContact {
 public:
  SetsContact(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters)
      : a_(a), b_(b), parts_(a.body->as<PartSet>()), counters_(counters) {}

  PartContact run() {
    descend(parts_.levels().size(), 0);
    return found_;
  }
  // Each part of one set against each of the other.
  PartContact run_without_trees() {
    trees_ = false;
    parts_.any_part([this](const PartShape& part, std::size_t place) { return try_part(part, place); });
    return found_;
  }

 private:
  const PosedPolytope &a_, &b_;
  const PartSet& parts_;
  PairCounters& counters_;
  PartContact found_;
  bool trees_ = true;

  double margin() const { return a_.body->inflation_radius + b_.body->inflation_radius; }

  bool is_near(const PartShape& box) {
    PartBody& filled = part_bodies().b;
    filled.fill(box, 0);
    return PartWalk(PosedPolytope{&filled.body(), a_.pose}, b_, margin()).any_leaf([](std::size_t, unsigned) {
      return true;
    });
  }

  void descend(std::size_t level, std::size_t index) {
    if (level == 0) return try_leaf(index);
    const PartNode& node = parts_.levels()[level - 1][index];
    for (std::size_t k = 0; k < kChildren && !found_.shared; ++k) {
      const PartShape box = box_of(parts_, node, k);
      if (box.corners != 0 && is_near(box)) descend(level - 1, index * kChildren + k);
    }
  }

  void try_leaf(std::size_t leaf) {
    for (std::size_t k = 0; k < kPartsInLeaf && !found_.shared; ++k) {
      const std::size_t place = leaf * kPartsInLeaf + k;
      const PartShape shape = parts_.shape(place);
      if (shape.corners != 0) try_part(shape, place);
    }
  }

  bool try_part(const PartShape& shape, std::size_t place) {
    PartBody& filled = part_bodies().b;
    filled.fill(shape, a_.body->inflation_radius);
    const InnerBall inner = filled.inner_ball();
    const PosedPolytope part{&filled.body(), a_.pose};
    const std::int32_t met = trees_ ? place_met(b_, part, &inner, -1, counters_) : first_place_met(b_, part, counters_);
    if (met >= 0) found_ = {true, static_cast<std::int32_t>(place), met};
    return found_.shared;
  }
};

// Parts that are further away are not looked for.
double farthest(const PairDistance& best, const PartVisitor* visit) {
  return best.upper + (visit != nullptr ? visit->room : 0);
}

// The least distance of a set's parts from a body that is no set: nodes nearest first.
class PartsDistance {
 public:
  PartsDistance(const PosedPolytope& set, const PosedPolytope& body, double limit, PairCounters& counters,
                const PartVisitor* visit)
      : set_(set),
        body_(body),
        parts_(set.body->as<PartSet>()),
        walk_(body, set, 0),
        limit_(limit),
        counters_(counters),
        visit_(visit) {}

  // `set_is_a`: whether A is the set, which decides how directions and points are given.
  PairDistance run(bool set_is_a, bool trees = true) {
    set_is_a_ = set_is_a;
    if (!trees) {
      for (std::size_t leaf = 0; leaf < parts_.leaf_count(); ++leaf) measure(leaf);
      return best_;
    }
    waiting_.push({0, parts_.levels().size(), 0});
    // Where the search ends, all that is left is at least as far away as the next node.
    while (!waiting_.empty() && !(waiting_.top().gap > limit_) && !(waiting_.top().gap >= farthest(best_, visit_))) {
      const Waiting next = waiting_.top();
      waiting_.pop();
      if (next.level == 0) {
        measure(next.index);
      } else {
        open(next);
      }
    }
    if (!waiting_.empty()) best_.lower = smaller(best_.lower, waiting_.top().gap);
    return best_;
  }

 private:
  struct Waiting {
    double gap;  // a lower bound, m
    std::size_t level, index;

    bool operator<(const Waiting& other) const { return gap > other.gap; }
  };

  const PosedPolytope &set_, &body_;
  const PartSet& parts_;
  PartWalk walk_;
  double limit_;
  PairCounters& counters_;
  const PartVisitor* visit_;
  bool set_is_a_ = false;
  std::priority_queue<Waiting> waiting_;
  PairDistance best_ = PairDistance::nothing_near();

  void open(const Waiting& node) {
    const PartNode& boxes = parts_.levels()[node.level - 1][node.index];
    const NearParts found = walk_.near(boxes);
    const double radii = set_.body->inflation_radius + body_.body->inflation_radius;
    for (std::size_t k = 0; k < kChildren; ++k) {
      if (!(boxes.half[0][k] >= 0)) continue;
      const double apart = static_cast<double>(found.gap[k]) / parts_.units() * kPartGapRounding - radii;
      waiting_.push({larger(node.gap, apart), node.level - 1, node.index * kChildren + k});
    }
  }

  void measure(std::size_t leaf) {
    PartBody& filled = part_bodies().a;
    for (std::size_t k = 0; k < kPartsInLeaf; ++k) {
      const PartShape shape = parts_.shape(leaf * kPartsInLeaf + k);
      if (shape.corners == 0) continue;
      best_.take(of_part(shape, filled, smaller(limit_, farthest(best_, visit_))));
    }
  }

  PairDistance of_part(const PartShape& shape, PartBody& filled, double limit) {
    if (!body_.body->traits().fills_hull()) {
      const Polytope part = polytope_of(shape, set_.body->inflation_radius);
      const PosedPolytope posed{&part, set_.pose};
      return set_is_a_ ? pair_distance(posed, body_, limit, counters_, visit_)
                       : pair_distance(body_, posed, limit, counters_, visit_);
    }
    filled.fill(shape, set_.body->inflation_radius);
    const PosedPolytope posed{&filled.body(), set_.pose};
    const PosedPolytope &a = set_is_a_ ? posed : body_, &b = set_is_a_ ? body_ : posed;
    const PairDistance found = convex_distance(a, b, limit, counters_);
    if (visit_ != nullptr) visit_->show(a, b, found);
    return found;
  }
};

// The least distance of two sets: over the parts of the first set, one after another.
PairDistance sets_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit,
                           PairCounters& counters, bool trees, const PartVisitor* visit) {
  const PartSet& parts = body_a.body->as<PartSet>();
  PairDistance best = PairDistance::nothing_near();
  PartBody filled;
  parts.any_part([&](const PartShape& shape, std::size_t) {
    filled.fill(shape, body_a.body->inflation_radius);
    const PosedPolytope posed{&filled.body(), body_a.pose};
    best.take(PartsDistance(body_b, posed, smaller(limit, farthest(best, visit)), counters, visit).run(false, trees));
    return false;
  });
  return best;
}

}  // namespace

PartContact parts_contact(const PosedPolytope& a, const PosedPolytope& b, const PartContact& guess,
                          PairCounters& counters, bool trees) {
  const Sets sets = sets_of(*a.body, *b.body);
  if (sets.are_both()) {
    const bool first = a.body->as<PartSet>().part_count() <= b.body->as<PartSet>().part_count();
    SetsContact search(first ? a : b, first ? b : a, counters);
    const PartContact found = trees ? search.run() : search.run_without_trees();
    return first ? found : PartContact{found.shared, found.b, found.a};
  }
  const bool first = sets.first;
  const PosedPolytope &set = first ? a : b, &body = first ? b : a;
  const std::int32_t met =
      trees ? place_met(set, body, nullptr, first ? guess.a : guess.b, counters) : first_place_met(set, body, counters);
  return first ? PartContact{met >= 0, met, -1} : PartContact{met >= 0, -1, met};
}

PairDistance parts_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit, double least,
                            PairCounters& counters, bool trees, const PartVisitor* visit) {
  const Sets sets = sets_of(*body_a.body, *body_b.body);
  PairDistance found = sets.are_both() ? sets_distance(body_a, body_b, limit, counters, trees, visit)
                                       : PartsDistance(sets.first ? body_a : body_b, sets.first ? body_b : body_a,
                                                       limit, counters, visit)
                                             .run(sets.first, trees);
  found.lower = larger(found.lower, least);
  return found;
}

}  // namespace plannercheck
