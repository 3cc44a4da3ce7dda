#include "narrow_phase/part_walk.hpp"

#include <algorithm>
#include <utility>

#include "narrow_phase/support.hpp"

namespace plannercheck {
namespace {

// Coordinates in floats err by this times all that is added up to get them, as in tree_frames. Since 1 and more is
// added up, that is also far above what denormals lose.
constexpr float kPartFloats = 0x1p-20F;

// Numbers are rounded to floats by at most this part of themselves, and their bounds are computed in as many steps.
constexpr double kPartRoundedUp = 1 + 0x1p-20;

// Poses are off rigid by at most δ = 3.6e-6 (plannercheck/robots/unit_lengths.py), ‖MᵀM − 1‖: M⁻¹ differs from Mᵀ by at
// most δ (1 + δ), as do products of two such matrices from what they stand for by 2 δ. Rounding is far below that.
constexpr double kTurnError = 1e-5;

// Radii and margins, as parts of which lengths in a frame and in the world differ by less than 2e-6. It also takes back
// what the margin was stretched by (kRadiusStretch).
constexpr double kWithinFrames = 1 - 1e-5;

}  // namespace

RigidTurn::RigidTurn(const Pose& body, const Pose& set) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      m_[3 * i + j] = (set.m[i] * body.m[j] + set.m[i + 4] * body.m[j + 4]) + set.m[i + 8] * body.m[j + 8];
    }
  }
  const Vec3 way = body.translation() - set.translation();
  in_set_ = set.rotate_back(way), in_body_ = -body.rotate_back(way);
  distance_ = norm_1(way);
}

double RigidTurn::error(double reach) const { return kTurnError * (reach + distance_) + kDenormalError; }

PartWalk::PartWalk(const PosedPolytope& body, const PosedPolytope& set, double margin, const InnerBall* inner)
    : set_(set.body->as<PartSet>()),
      body_(body.body),
      inner_(inner),
      turn_(body.pose, set.pose),
      margin_(margin * kRadiusStretch) {
  const Polytope& box = *body.body;
  const Vec3 reach = Box{box.low, box.high}.reach(), parts = set_.box().reach();
  box_centre_ = 0.5 * (box.low + box.high), box_half_ = 0.5 * (box.high - box.low);
  const double both = norm_1(reach) + norm_1(parts) + margin_;
  room_ = turn_.error(both);
  frame_tree();
}

void PartWalk::frame_tree() {
  const double units = set_.units();
  const Vec3 there = units * (turn_.to_set(box_centre_) - set_.middle());
  for (std::size_t i = 0; i < 3; ++i) {
    double half = margin_ + room_;
    for (std::size_t j = 0; j < 3; ++j) half += std::fabs(turn_.entry(i, j)) * box_half_[j];
    centre_[i] = static_cast<float>(there[i]);
    half_[i] = static_cast<float>(units * half * kPartRoundedUp) * (1 + kPartFloats) +
               static_cast<float>(std::fabs(there[i]) + 2) * kPartFloats;
  }
  const Vec3 way = turn_.to_body(set_.middle()) - box_centre_;
  for (std::size_t i = 0; i < 3; ++i) {
    axes_[i] = along({turn_.entry(0, i), turn_.entry(1, i), turn_.entry(2, i)}, way[i], box_half_[i]);
  }
}

// `to`: a direction of the body's frame in the set's. `way`, `half`: from the middle of what the body takes up along it
// to the set's middle, and half of that, m. Boxes of balls are larger along it than the balls are, by |to|_1 − 1 of
// their radius.
inline PartWalk::Along PartWalk::along(Vec3 to, double way, double half) const {
  Along out;
  const double units = set_.units(), turned = norm_1(to);
  for (std::size_t i = 0; i < 3; ++i) {
    out.along[i] = static_cast<float>(to[i]);
    out.size[i] = std::fabs(out.along[i]);
  }
  const double larger_by = set_.has_one_radius() ? units * set_.radius(0) * larger(turned - 1, 0) : 0;
  out.shift = static_cast<float>(units * way);
  out.extent = static_cast<float>(units * (half + margin_ + room_) * kPartRoundedUp) * (1 + kPartFloats) +
               static_cast<float>(1 + 2 * turned + units * std::fabs(way)) * kPartFloats -
               static_cast<float>(larger_by) * (1 - kPartFloats);
  return out;
}

// Whatever the direction: the body ends where its own extreme vertex does.
void PartWalk::keep_direction() {
  PairCounters& counters = *std::exchange(counters_, nullptr);
  const Vec3 direction = unit(way_);
  if (!(dot(direction, direction) > 0)) return;  // of no length, or not finite
  ++counters.queries_a;
  const std::int32_t last = extreme(body_->inner, direction, counters.queries);
  const auto entry = [&](std::size_t i) {
    return dot({turn_.entry(i, 0), turn_.entry(i, 1), turn_.entry(i, 2)}, direction);
  };
  const Vec3 past_body = turn_.to_body(set_.middle()) - body_->inner.points[at(last)];
  beyond_[oldest_] = along({entry(0), entry(1), entry(2)}, dot(direction, past_body), 0);
  oldest_ = (oldest_ + 1) % kMostBeyond;
  beyond_count_ = std::min(beyond_count_ + 1, kMostBeyond);
}

// By how much the node's boxes are beyond the body's along the set's axes.
inline Floats PartWalk::own_gaps(const PartNode& node) const {
  const auto gap = [&](std::size_t i) {
    return absolute(load_floats(node.centre[i].data()) - centre_[i]) - (load_floats(node.half[i].data()) + half_[i]);
  };
  return larger(larger(gap(0), gap(1)), gap(2));
}

inline NearParts PartWalk::with_directions(const PartNode& node, Floats own) const {
  const auto centre = [&](std::size_t i) { return load_floats(node.centre[i].data()); };
  const auto half = [&](std::size_t i) { return load_floats(node.half[i].data()); };
  const Floats x = centre(0), y = centre(1), z = centre(2), u = half(0), v = half(1), w = half(2);
  const auto there = [&](const Along& to) {
    return (to.along[0] * x + to.along[1] * y) + (to.along[2] * z + to.shift);
  };
  const auto around = [&](const Along& to) { return (to.size[0] * u + to.size[1] * v) + (to.size[2] * w + to.extent); };
  Floats all = own;
  for (const Along& axis : axes_) all = larger(all, absolute(there(axis)) - around(axis));
  for (std::size_t k = 0; k < beyond_count_; ++k) all = larger(all, there(beyond_[k]) - around(beyond_[k]));
  const FloatMask missing = u < 0.0F;
  return {~(bits(own > 0.0F) | bits((all > 0.0F) | missing)) & ((1U << kChildren) - 1), all};
}

NearParts PartWalk::near(const PartNode& node) const { return with_directions(node, own_gaps(node)); }

// Along the set's axes most boxes of the last nodes are far from the body.
NearParts PartWalk::near_children(const PartNode& node) const {
  const Floats own = own_gaps(node);
  if (bits(own > 0.0F) == (1U << kChildren) - 1) return {0, own};
  return with_directions(node, own);
}

unsigned PartWalk::near_in_leaf(std::size_t leaf) const {
  if (set_.kind() != PartSet::Kind::kBalls) return near_children(set_.leaf_boxes(leaf)).bits;
  const EightPoints& points = set_.points(leaf);
  const std::size_t first = leaf * kPartsInLeaf, left = set_.part_count() - first;
  unsigned near = 0;
  for (std::size_t k = 0; k < kPartsInLeaf; k += kLanes) {
    const Lanes x = load_lanes(&points.x[k]), y = load_lanes(&points.y[k]), z = load_lanes(&points.z[k]);
    Lanes beyond = broadcast(-1e300);
    for (std::size_t i = 0; i < 3; ++i) {
      const double shift = turn_.in_body()[i] - box_centre_[i];
      const Lanes there = ((turn_.entry(0, i) * x + turn_.entry(1, i) * y) + turn_.entry(2, i) * z) + shift;
      beyond = larger(beyond, absolute(there) - box_half_[i]);
    }
    const double room = set_.largest_radius() * kRadiusStretch + margin_ + room_;
    near |= (~bits(beyond > broadcast(room)) & ((1U << kLanes) - 1)) << k;
  }
  return left < kPartsInLeaf ? near & ((1U << left) - 1) : near;
}

std::span<const InnerBall> PartWalk::inner_balls() const {
  return inner_ != nullptr ? std::span(inner_, 1) : std::span(body_->inner_shapes().balls);
}

// Here and below, squares of shorter lengths would lose bits to underflow.
unsigned PartWalk::surely_shared(std::size_t leaf) const {
  const EightPoints& points = set_.points(leaf);
  unsigned shared = 0;
  const std::size_t first = leaf * kPartsInLeaf;
  for (const InnerBall& ball : inner_balls()) {
    for (std::size_t k = 0; k < kPartsInLeaf; k += kLanes) {
      const Lanes x = load_lanes(&points.x[k]), y = load_lanes(&points.y[k]), z = load_lanes(&points.z[k]);
      Lanes square{};
      for (std::size_t i = 0; i < 3; ++i) {
        const double shift = turn_.in_body()[i] - ball.centre[i];
        const Lanes d = ((turn_.entry(0, i) * x + turn_.entry(1, i) * y) + turn_.entry(2, i) * z) + shift;
        square = square + d * d;
      }
      Lanes radius;
      for (std::size_t lane = 0; lane < kLanes; ++lane) radius[lane] = set_.radius(first + k + lane);
      const Lanes near = (radius + (ball.radius + margin_)) * kWithinFrames - room_;
      shared |= (bits(square < near * near) & bits(near > broadcast(kTrustedLength))) << k;
    }
  }
  return shared;
}

bool PartWalk::surely_shares(const PartShape& part) const {
  if (part.corners != 8) return false;
  const Vec3 low = part.corner[0], high = part.corner[7];
  for (const InnerBall& ball : inner_balls()) {
    const Vec3 c = turn_.to_set(ball.centre);
    const Vec3 d = larger(Vec3{}, larger(low - c, c - high));
    const double near = (ball.radius + margin_) * kWithinFrames - room_;
    if (near > kTrustedLength && dot(d, d) < near * near) return true;
  }
  return false;
}

}  // namespace plannercheck
