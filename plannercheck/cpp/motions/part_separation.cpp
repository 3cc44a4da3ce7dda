#include "motions/part_separation.hpp"

#include <algorithm>

#include "bodies/part_body.hpp"
#include "math/simd.hpp"
#include "motions/adaptive_subdivision.hpp"
#include "narrow_phase/distance.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kLooksAtMost = 2;  // at poses of a set that moves in the frame
constexpr auto kPoseLanes = static_cast<std::size_t>(kLanes);
constexpr std::size_t kAxesOfBoth = 6;
constexpr std::size_t kKeptDirections = 12;  // the last ones are overwritten in turn

// Floats err by this part of all that is added up, and of the limit. It also covers that the boxes' sides are taken
// along the set's axes, where radii, which are lengths of the world, may be longer by 1.8e-6.
constexpr double kPartProjection = 0x1p-19;

// How far radii may be stretched along directions of frames that are off rigid.
constexpr double kPartStretch = 1 + 2e-6;

// The rounding of a box's half extents along a direction: products and sums of doubles.
constexpr double kBoxSums = 1 + 1e-12;

struct Interval {
  double low, high;
};

// The set's boxes along a direction of the world, and the body's interval there, both from the same origin.
struct AlongDirection {
  std::array<float, 3> along, size;  // per unit of the tree
  Vec3 way;                          // in the set's frame, per m
  double offset;                     // of the set's origin
  float middle;                      // of the tree's middle, from the body's
  float least;                       // how far boxes have to be from the body's middle, with errors
  Interval body;                     // with the limit
};

Interval grown(Interval interval, double by) { return {interval.low - by, interval.high + by}; }

class PartSeparation {
 public:
  PartSeparation(const Polytope& set, const Polytope& body, bool set_is_first, const PosedPair* poses, int count,
                 double limit, PairCounters& counters, bool trees)
      : set_(set.as<PartSet>()),
        body_(body),
        set_is_first_(set_is_first),
        poses_(poses),
        count_(static_cast<std::size_t>(count)),
        limit_(limit),
        counters_(counters),
        trees_(trees) {
    looks_ = count_ > 1 && stands_still() ? 1 : count_;
    if (looks_ == 1) fill_rows();
  }

  bool run() {
    if (looks_ > kLooksAtMost) return false;
    if (!trees_) return each_swept_apart();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add_axis(body_pose(count_ / 2), axis);
      add_axis(set_pose(0), axis);
    }
    std::array<std::pair<std::size_t, std::size_t>, kMostWaiting> waiting;
    std::size_t count = 0;
    waiting[count++] = {set_.levels().size(), 0};
    while (count > 0) {
      const auto [level, index] = waiting[--count];
      if (level == 0) {
        if (!leaf_apart(index)) return false;
        continue;
      }
      unsigned left = near(set_.levels()[level - 1][index]);
      for (; left != 0; left &= left - 1) {
        waiting[count++] = {level - 1, index * kChildren + static_cast<std::size_t>(__builtin_ctz(left))};
      }
    }
    return true;
  }

 private:
  static constexpr std::size_t kMostWaiting = 12 * kChildren;
  typedef std::array<AlongDirection, kLooksAtMost> AtPoses;

  const PartSet& set_;
  const Polytope& body_;
  bool set_is_first_;
  const PosedPair* poses_;
  std::size_t count_;
  // At how many poses the set has to be looked at: at one if it stands still in the frame, against the body's intervals
  // at all poses together.
  std::size_t looks_ = 1;
  double limit_;
  PairCounters& counters_;
  bool trees_;
  std::array<AtPoses, kKeptDirections> directions_;
  std::array<std::array<double, kGridStates>, 12> rows_;  // if the set is looked at once
  std::size_t groups_ = 0;
  std::size_t kept_ = 0, next_ = kAxesOfBoth, newest_ = 0;

  const Pose& set_pose(std::size_t p) const { return set_is_first_ ? poses_[p].a : poses_[p].b; }
  const Pose& body_pose(std::size_t p) const { return set_is_first_ ? poses_[p].b : poses_[p].a; }

  bool stands_still() const {
    for (std::size_t p = 1; p < count_; ++p) {
      if (set_pose(p).m != set_pose(0).m || poses_[p].frame.m != poses_[0].frame.m) return false;
    }
    return true;
  }

  // The body's poses in lanes, the last one in those that are left: number k of the pose p at rows_[k][p].
  void fill_rows() {
    groups_ = (count_ + kPoseLanes - 1) / kPoseLanes;
    for (std::size_t p = 0; p < groups_ * kPoseLanes; ++p) {
      const Pose& pose = body_pose(std::min(p, count_ - 1));
      for (std::size_t k = 0; k < 12; ++k) rows_[k][p] = pose.m[k];
    }
  }

  // A direction of the frame at all poses at which the set is looked at.
  void project(Vec3 d, bool of_hull, AtPoses& out) {
    for (std::size_t p = 0; p < looks_; ++p) {
      const Vec3 in_world = poses_[p].frame.to_world(d);
      const std::size_t past = looks_ == 1 ? count_ : p + 1;
      Interval body = looks_ == 1 ? box_interval(in_world) : box_interval(p, in_world);
      if (of_hull) {
        const double end = hull_end(in_world, p, past);
        (set_is_first_ ? body.high : body.low) = end;
      }
      out[p] = projected(p, in_world, grown(body, limit_));
    }
  }

  void add_axis(const Pose& pose, std::size_t axis) {
    const Vec3 d = unit(poses_[0].frame.from_world({pose.m[axis], pose.m[axis + 4], pose.m[axis + 8]}));
    project(d, false, directions_[kept_++]);
  }

  // Keeps a direction of the frame that kept a part away.
  void add_direction(Vec3 d) {
    if (kept_ < kKeptDirections) next_ = kept_++;
    newest_ = next_;
    project(d, true, directions_[newest_]);
    next_ = next_ + 1 < kKeptDirections ? next_ + 1 : kAxesOfBoth;
  }

  AlongDirection projected(std::size_t p, Vec3 d, Interval body) const {
    AlongDirection out;
    out.way = set_pose(p).rotate_back(d);
    out.offset = dot(d, set_pose(p).translation());
    out.body = body;
    const double units = set_.units(), mid = 0.5 * (out.body.low + out.body.high);
    const double from = (dot(out.way, set_.middle()) + out.offset - mid) * units;
    double sum = 2 + std::fabs(from);
    for (std::size_t i = 0; i < 3; ++i) {
      out.along[i] = static_cast<float>(out.way[i]);
      out.size[i] = std::fabs(out.along[i]);
      sum += 2 * std::fabs(out.way[i]);
    }
    out.middle = static_cast<float>(from);
    const double half = 0.5 * (out.body.high - out.body.low) * units;
    out.least = static_cast<float>((half + sum * kPartProjection) * (1 + kPartProjection));
    return out;
  }

  Interval box_interval(std::size_t p, Vec3 d) const {
    const Pose& pose = body_pose(p);
    const Vec3 local = pose.rotate_back(d), centre = 0.5 * (body_.low + body_.high), half = body_.high - centre;
    const double middle = dot(local, centre) + dot(d, pose.translation());
    const double size =
        (std::fabs(local.x) * half.x + std::fabs(local.y) * half.y + std::fabs(local.z) * half.z) * kBoxSums;
    return {middle - size, middle + size};
  }

  // The interval of the body's box over all poses.
  Interval box_interval(Vec3 d) const {
    const Vec3 centre = 0.5 * (body_.low + body_.high), half = body_.high - centre;
    Lanes least = broadcast(kNoLimit), most = -least;
    for (std::size_t p = 0; p < groups_ * kPoseLanes; p += kPoseLanes) {
      const auto row = [&](std::size_t k) { return load_lanes(&rows_[k][p]); };
      Lanes middle = (row(3) * d.x + row(7) * d.y) + row(11) * d.z, size{};
      for (std::size_t k = 0; k < 3; ++k) {
        const Lanes along = (row(k) * d.x + row(k + 4) * d.y) + row(k + 8) * d.z;
        middle = middle + along * centre[k];
        size = size + absolute(along) * half[k];
      }
      size = size * kBoxSums;
      least = smaller(least, middle - size), most = larger(most, middle + size);
    }
    Interval all{least[0], most[0]};
    for (int k = 1; k < kLanes; ++k) all = {smaller(all.low, least[k]), larger(all.high, most[k])};
    return all;
  }

  // Where the body ends at these poses, on the side of the set: along a direction of the world, from b to a.
  double hull_end(Vec3 d, std::size_t from, std::size_t past) {
    double end = set_is_first_ ? -kNoLimit : kNoLimit;
    for (std::size_t p = from; p < past; ++p) {
      const Pose& pose = body_pose(p);
      const Vec3 local = pose.rotate_back(d);
      ++counters_.queries_a;
      const std::int32_t v = extreme(body_.inner, set_is_first_ ? local : -local, counters_.queries);
      const double along = dot(d, pose.apply(body_.inner.points[at(v)]));
      end = set_is_first_ ? larger(end, along) : smaller(end, along);
    }
    return end;
  }

  // Children of a node that no direction keeps away.
  unsigned near(const PartNode& node) const {
    const auto row = [&](const auto& from, const std::array<float, 3>& by) {
      return (by[0] * load_floats(from[0].data()) + by[1] * load_floats(from[1].data())) +
             by[2] * load_floats(from[2].data());
    };
    unsigned left = ~bits(load_floats(node.half[0].data()) < 0.0F) & ((1U << kChildren) - 1);
    for (std::size_t k = kept_; k-- > 0 && left != 0;) {
      FloatMask before = ~FloatMask{}, after = before;
      for (std::size_t p = 0; p < looks_; ++p) {
        const AlongDirection& to = directions_[k][p];
        const Floats way = row(node.centre, to.along) + to.middle, room = row(node.half, to.size) + to.least;
        before &= way > room, after &= -way > room;
      }
      left &= ~bits(before | after);
    }
    return left;
  }

  bool leaf_apart(std::size_t leaf) {
    if (set_.kind() == PartSet::Kind::kBalls) return balls_apart(leaf);
    unsigned left = near(set_.leaf_boxes(leaf));
    for (; left != 0; left &= left - 1) {
      const PartShape part = part_at(leaf, left);
      if (part.corners != 0 && !part_apart(part)) return false;
    }
    return true;
  }

  // All balls of a leaf along a direction at once, then one by one those that no direction keeps away.
  bool balls_apart(std::size_t leaf) {
    const std::size_t there = set_.part_count() - leaf * kPartsInLeaf;
    unsigned left = there < kPartsInLeaf ? (1U << there) - 1 : (1U << kPartsInLeaf) - 1;
    for (std::size_t k = kept_; k-- > 0 && left != 0;) left &= balls_beside(leaf, directions_[k]);
    while (left != 0) {
      if (!swept_apart(part_at(leaf, left))) return false;
      left &= left - 1;
      if (left != 0) left &= balls_beside(leaf, directions_[newest_]);
    }
    return true;
  }

  // Balls of a leaf that a direction does not keep away.
  unsigned balls_beside(std::size_t leaf, const AtPoses& direction) const {
    const EightPoints& points = set_.points(leaf);
    unsigned beside = 0;
    for (std::size_t first = 0; first < kPartsInLeaf; first += kLanes) {
      const Lanes x = load_lanes(&points.x[first]), y = load_lanes(&points.y[first]), z = load_lanes(&points.z[first]);
      Lanes radius = broadcast(set_.largest_radius());
      for (std::size_t k = 0; k < kLanes && !set_.has_one_radius(); ++k)
        radius[k] = set_.radius(leaf * kPartsInLeaf + first + k);
      radius = radius * kPartStretch;
      unsigned before = (1U << kLanes) - 1, after = before;
      for (std::size_t p = 0; p < looks_; ++p) {
        const AlongDirection& to = direction[p];
        const Lanes at = (to.way.x * x + to.way.y * y) + to.way.z * z + to.offset;
        before &= bits(at + radius < broadcast(to.body.low)), after &= bits(at - radius > broadcast(to.body.high));
      }
      beside |= (~(before | after) & ((1U << kLanes) - 1)) << first;
    }
    return beside;
  }

  // The first part of a leaf that a bit stands for.
  PartShape part_at(std::size_t leaf, unsigned left) const {
    return set_.shape(leaf * kPartsInLeaf + static_cast<std::size_t>(__builtin_ctz(left)));
  }

  bool part_apart(const PartShape& part) {
    const double radius = part.radius * kPartStretch;
    for (std::size_t k = kept_; k-- > 0;) {
      if (separates(directions_[k], part, radius)) return true;
    }
    return swept_apart(part);
  }

  bool each_swept_apart() {
    return !set_.any_part([this](const PartShape& part, std::size_t) { return !swept_apart(part); });
  }

  // Whether the body sweeps past a part, which gives a direction for the next ones.
  bool swept_apart(const PartShape& part) {
    thread_local PartBody filled;
    filled.fill(part, 0);
    const Polytope &a = set_is_first_ ? filled.body() : body_, &b = set_is_first_ ? body_ : filled.body();
    const PosedPair& middle = poses_[count_ / 2];
    const Vec3 hint = middle.frame.from_world(middle.a.apply(a.centre) - middle.b.apply(b.centre));
    const double limit = limit_ + part.radius * kPartStretch;
    if (trees_ && count_ > 2) {  // mostly, a direction that separates both ends separates all poses
      const std::array<PosedPair, 2> ends{poses_[0], poses_[count_ - 1]};
      const SweptAnswer<Vec3> answer = swept_distance(a, b, ends.data(), 2, limit, hint, counters_);
      if (!answer.apart) return false;
      add_direction(answer.direction);
      if (separates(directions_[newest_], part, part.radius * kPartStretch)) return true;
    }
    const SweptAnswer<Vec3> answer = swept_distance(a, b, poses_, static_cast<int>(count_), limit, hint, counters_);
    if (!answer.apart) return false;
    add_direction(answer.direction);
    return true;
  }

  bool separates(const AtPoses& direction, const PartShape& part, double radius) const {
    bool before = true, after = true;
    for (std::size_t p = 0; p < looks_; ++p) {
      const AlongDirection& to = direction[p];
      double low = dot(to.way, part.corner[0]), high = low;
      for (std::size_t c = 1; c < part.corners; ++c) {
        const double here = dot(to.way, part.corner[c]);
        low = smaller(low, here), high = larger(high, here);
      }
      before &= high + to.offset + radius < to.body.low;
      after &= low + to.offset - radius > to.body.high;
    }
    return before || after;
  }
};

// Each part of the smaller set against the larger one.
bool sets_further(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit,
                  PairCounters& counters, bool trees) {
  const bool first = a.as<PartSet>().part_count() >= b.as<PartSet>().part_count();
  const PartSet& smaller_set = (first ? b : a).as<PartSet>();
  thread_local PartBody mover;
  return !smaller_set.any_part([&](const PartShape& part, std::size_t) {
    mover.fill(part, 0);
    const double apart = limit + part.radius * kPartStretch;
    return !PartSeparation(first ? a : b, mover.body(), first, poses, count, apart, counters, trees).run();
  });
}

}  // namespace

bool parts_further(const Polytope& a, const Polytope& b, const PosedPair* poses, int count, double limit,
                   PairCounters& counters, bool trees) {
  const Sets sets = sets_of(a, b);
  const bool first = sets.first;
  if (sets.are_both()) return sets_further(a, b, poses, count, limit, counters, trees);
  return PartSeparation(first ? a : b, first ? b : a, first, poses, count, limit, counters, trees).run();
}

}  // namespace plannercheck
