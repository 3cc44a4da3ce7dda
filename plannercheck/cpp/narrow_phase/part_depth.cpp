#include "narrow_phase/part_depth.hpp"

#include <algorithm>
#include <vector>

#include "bodies/part_body.hpp"
#include "narrow_phase/minkowski_difference.hpp"
#include "narrow_phase/part_pair.hpp"
#include "narrow_phase/part_walk.hpp"

namespace plannercheck {
namespace {

// A translation that leaves a part at contact is longer by so many bounds of the rounding of the pair's heights.
constexpr double kBeyondContact = 8;

class PartDepth {
 public:
  PartDepth(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters)
      : body_a_(body_a),
        body_b_(body_b),
        set_is_a_(sets_of(*body_a.body, *body_b.body).first),
        set_(set_is_a_ ? body_a : body_b),
        parts_(set_.body->as<PartSet>()),
        counters_(counters) {}

  // `found`: that of pair_distance, where the bodies overlap.
  PairDistance run(PairDistance found) {
    find_overlaps();
    if (overlaps_.empty()) return found;
    const PartOverlap& deepest =
        *std::min_element(overlaps_.begin(), overlaps_.end(),
                          [](const PartOverlap& a, const PartOverlap& b) { return a.found.upper < b.found.upper; });
    found.upper = smaller(found.upper, deepest.found.upper);
    const Vec3 way = deepest.found.direction;
    const double length =
        longest_exit(way) + kBeyondContact * MinkowskiDifference(body_a_, body_b_, counters_).support_error();
    if (!(length < -found.lower)) return found;
    PosedPolytope moved = body_a_;
    moved.pose.m[3] += length * way.x, moved.pose.m[7] += length * way.y, moved.pose.m[11] += length * way.z;
    const double moved_by = norm_above(moved.pose.translation() - body_a_.pose.translation());
    if (!(moved_by < -found.lower) || parts_contact(moved, body_b_, {}, counters_).shared) return found;
    found.lower = -moved_by, found.direction = way;
    found.on_body_a = deepest.found.on_body_a, found.on_body_b = found.on_body_a + moved_by * way;
    return found;
  }

 private:
  struct PartOverlap {
    std::size_t place;
    PairDistance found;
  };

  const PosedPolytope &body_a_, &body_b_;
  bool set_is_a_;
  const PosedPolytope& set_;
  const PartSet& parts_;
  PairCounters& counters_;
  PartBody filled_;
  std::vector<PartOverlap> overlaps_;

  PosedPolytope part(std::size_t place) {
    filled_.fill(parts_.shape(place), set_.body->inflation_radius);
    return {&filled_.body(), set_.pose};
  }

  void find_overlaps() {
    const PosedPolytope& hull = set_is_a_ ? body_b_ : body_a_;
    PartWalk walk(hull, set_, set_.body->inflation_radius + hull.body->inflation_radius);
    walk.any_leaf([&](std::size_t leaf, unsigned near) {
      for (; near != 0; near &= near - 1) {
        const std::size_t place = leaf * kPartsInLeaf + static_cast<std::size_t>(__builtin_ctz(near));
        if (parts_.shape(place).corners == 0) continue;
        const PosedPolytope one = part(place);
        const PairDistance found = convex_distance(set_is_a_ ? one : hull, set_is_a_ ? hull : one, 0, counters_);
        if (found.overlap) overlaps_.push_back({place, found});
      }
      return false;
    });
  }

  // How far all parts that overlap have to go along a direction: each until a plane along it, or along its own
  // direction, separates it.
  double longest_exit(Vec3 way) {
    double longest = 0;
    for (const PartOverlap& overlap : overlaps_) {
      double exit = overlap_along(part(overlap.place), way);
      const double turned = dot(overlap.found.direction, way);
      if (turned > 0) exit = smaller(exit, -overlap.found.lower / turned);
      longest = larger(longest, exit);
    }
    return longest;
  }

  double overlap_along(const PosedPolytope& one, Vec3 way) const {
    const PosedPolytope &a = set_is_a_ ? one : body_a_, &b = set_is_a_ ? body_b_ : one;
    const MinkowskiDifference differences(a, b, counters_);
    return a.body->inflation_radius + b.body->inflation_radius - dot(way, differences.lowest_along(way).difference);
  }
};

}  // namespace

PairDistance signed_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters) {
  const PairDistance found = pair_distance(body_a, body_b, kNoLimit, counters);
  const bool first = body_a.body->kind() == Kind::kPartSet;
  const Polytope &set = first ? *body_a.body : *body_b.body, &other = first ? *body_b.body : *body_a.body;
  const bool has_parts = set.kind() == Kind::kPartSet && other.kind() == Kind::kHull;
  return found.overlap && has_parts ? PartDepth(body_a, body_b, counters).run(found) : found;
}

}  // namespace plannercheck
