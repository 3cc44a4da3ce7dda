#include "narrow_phase/solid_distance.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "bodies/part_body.hpp"
#include "narrow_phase/tree_frames.hpp"
#include "narrow_phase/triangle_pair.hpp"

namespace plannercheck {
namespace {

// Frames stretch lengths by at most 4e-6, and directions by half of 2^-13.
constexpr double kGapRounding = 1 - 0x1p-13;

struct WaitingPair {
  BoxedNode a, b;
  double gap;  // a lower bound of the distance of all below, m
};

class DistanceSearch {
 public:
  DistanceSearch(const PosedPolytope& a, const PosedPolytope& b, double limit, PairCounters& counters,
                 const PartVisitor* visit)
      : body_a_(a),
        body_b_(b),
        a_{&a.body->surface(), a.pose},
        b_{&b.body->surface(), b.pose},
        a_to_b_(a_, b_, {a_.pose, b_.pose}, 0),
        b_to_a_(b_, a_, {b_.pose, a_.pose}, 0),
        radii_(a.body->inflation_radius + b.body->inflation_radius),
        limit_(limit),
        counters_(counters),
        visit_(visit) {}

  PairDistance run() {
    waiting_.push_back({{0, a_.solid->tree.root}, {0, b_.solid->tree.root}, 0});
    while (!waiting_.empty()) {
      const WaitingPair pair = waiting_.back();
      waiting_.pop_back();
      if (!(pair.gap - radii_ < farthest())) {
        // All below is at least that far away, which is no less than the distance, or than the limit.
        if (pair.gap - radii_ < best_.upper) best_.lower = std::min(best_.lower, pair.gap - radii_);
      } else if (pair.a.is_triangle() && pair.b.is_triangle()) {
        measure(~pair.a.child, ~pair.b.child);
      } else {
        divide(pair);
      }
    }
    return best_;
  }

 private:
  PosedPolytope body_a_, body_b_;
  PosedSolid a_, b_;
  TreeMap a_to_b_, b_to_a_;
  double radii_, limit_;
  PairCounters& counters_;
  const PartVisitor* visit_;
  PairDistance best_ = PairDistance::nothing_near();
  std::vector<WaitingPair> waiting_;
  PartBody filled_a_, filled_b_;  // one object each, filled again for every triangle

  // Pairs that are further apart are not looked for.
  double farthest() const { return std::min(best_.upper + (visit_ != nullptr ? visit_->room : 0), limit_); }

  void divide(const WaitingPair& pair) {
    const bool divides_a =
        pair.b.is_triangle() || (!pair.a.is_triangle() && pair.a.box.extent() * a_to_b_.scale() >= pair.b.box.extent());
    const BoxedNode &whole = divides_a ? pair.a : pair.b, &other = divides_a ? pair.b : pair.a;
    const TriangleTree& tree = (divides_a ? a_ : b_).solid->tree;
    const TriangleNode& node = tree.nodes[at(whole.child)];
    BoxAbroad abroad;
    (divides_a ? b_to_a_ : a_to_b_).put_abroad(other.box, abroad);
    const Floats gaps = children_gaps(node, abroad);
    const auto first = static_cast<std::ptrdiff_t>(waiting_.size());
    for (std::size_t k = 0; k < node.children; ++k) {
      const BoxedNode child = node.boxed(k);
      const double gap = static_cast<double>(gaps[k]) / tree.units * kGapRounding;
      const double least = std::isfinite(gap) ? larger(pair.gap, gap) : pair.gap;
      waiting_.push_back({divides_a ? child : pair.a, divides_a ? pair.b : child, least});
    }
    std::sort(waiting_.begin() + first, waiting_.end(),
              [](const WaitingPair& one, const WaitingPair& two) { return one.gap > two.gap; });
  }

  void measure(std::int32_t triangle_a, std::int32_t triangle_b) {
    fill(filled_a_, a_, triangle_a, body_a_), fill(filled_b_, b_, triangle_b, body_b_);
    const PosedPolytope a{&filled_a_.body(), a_.pose}, b{&filled_b_.body(), b_.pose};
    const PairDistance found = convex_distance(a, b, farthest(), counters_);
    if (visit_ != nullptr) visit_->show(a, b, found);
    best_.take(found);
  }

  static void fill(PartBody& out, const PosedSolid& posed, std::int32_t index, const PosedPolytope& of) {
    const TriangleCorners t = posed.solid->tree.corners(index);
    out.fill({{t[0], t[1], t[2]}, t.size(), 0}, of.body->inflation_radius);
  }
};

}  // namespace

PairDistance solid_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit, double least,
                            PairCounters& counters, const PartVisitor* visit) {
  PairDistance found = DistanceSearch(body_a, body_b, limit, counters, visit).run();
  found.overlap = false;
  found.lower = larger(found.lower, larger(least, 0));
  return found;
}

}  // namespace plannercheck
