#include "narrow_phase/penetration_depth.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "bodies/affine_dimension.hpp"
#include "bodies/quickhull.hpp"
#include "narrow_phase/expanding_polytope.hpp"

namespace plannercheck {
namespace {

// Differences are in units of a power of two unless their size is in this range, so that products of four lengths
// neither overflow nor underflow.
constexpr double kSmallestUnscaled = 0x1p-100, kLargestUnscaled = 0x1p100;

// A vertex is beyond a plane, and differences span another dimension, only by more than this part of the size. Only
// time depends on it.
constexpr double kTie = 8 * 0x1p-53;
// The bounds meet if they are within so many of the errors of both.
constexpr double kClosed = 4;
// Faces whose normals differ by less count as one plane.
constexpr double kSamePlane = 1e-6;
// The error of a normal's length, and of the difference of two normals.
constexpr double kUnitRounding = 16 * 0x1p-53;
// Rounds of doubles, of which each adds a corner, and of exact hulls, which are built anew in each.
constexpr int kMostRounds = 20000, kMostExactRounds = 400;

// Kept from pair to pair, as it grows.
struct DepthWorkspace {
  ExpandingPolytope polytope;
  std::vector<DifferenceCorner> corners;
  std::vector<Vec3> points;  // their differences
};

DepthWorkspace& depth_workspace() {
  thread_local DepthWorkspace workspace;
  return workspace;
}

double unit_of(double size) {
  if (!(size > 0) || !std::isfinite(size) || (size > kSmallestUnscaled && size < kLargestUnscaled)) return 1;
  return std::ldexp(1.0, std::max(-1000, std::min(-std::ilogb(size), 1000)));
}

class DepthSearch {
 public:
  DepthSearch(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters)
      : differences_(body_a, body_b, counters),
        unit_(unit_of(differences_.size())),
        difference_error_(differences_.difference_error() * unit_),
        support_error_(differences_.support_error() * unit_),
        tie_(kTie * differences_.size() * unit_),
        goal_(kClosed * (difference_error_ + support_error_)),
        w_(depth_workspace()),
        polytope_(w_.polytope) {
    w_.corners.clear();
  }

  HullDepth run(const Proximity& start, bool doubles) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(start.count); ++i)
      keep(differences_.corner(start.body_a[i], start.body_b[i]));
    if (spans_space() && !(doubles && expand())) expand_exactly();
    return in_metres();
  }

 private:
  MinkowskiDifference differences_;
  double unit_;  // of all lengths here
  double difference_error_, support_error_, tie_, goal_;
  DepthWorkspace& w_;
  ExpandingPolytope& polytope_;
  HullDepth best_;

  HullDepth in_metres() const {
    HullDepth out = best_;
    out.lower = best_.lower / unit_, out.upper = larger(best_.upper / unit_, 0);
    return out;
  }

  Vec3 difference(const DifferenceCorner& corner) const { return unit_ * corner.difference; }
  Vec3 difference(std::size_t i) const { return difference(w_.corners[i]); }

  void keep(const DifferenceCorner& corner) { w_.corners.push_back(corner); }

  bool is_kept(const DifferenceCorner& corner) const {
    return std::any_of(w_.corners.begin(), w_.corners.end(), [&](const DifferenceCorner& other) {
      return other.vertex_a == corner.vertex_a && other.vertex_b == corner.vertex_b;
    });
  }

  // The difference furthest along an outward normal; its height is an upper bound of the depth.
  DifferenceCorner furthest_along(Vec3 outward) {
    const DifferenceCorner corner = differences_.lowest_along(-outward);
    const double upper = dot(outward, difference(corner)) + support_error_;
    if (upper < best_.upper) best_.upper = upper, best_.direction = -outward, best_.on_body_a = corner.body_a;
    return corner;
  }

  // Adds corners to at most four that span space as far as doubles tell. False if the difference is flat: then the
  // depth is no more than rounding, which the upper bound shows.
  bool spans_space() {
    if (w_.corners.empty()) keep(furthest_along({1, 0, 0}));
    std::size_t count = 1;
    for (std::size_t next = 1; next < w_.corners.size() && count < 4; ++next) {
      if (std::fabs(height_over_span(count, difference(next))) > tie_) std::swap(w_.corners[count++], w_.corners[next]);
    }
    w_.corners.resize(count);
    for (; count < 4; ++count) {
      const Vec3 normal = across_span(count);
      if (!keep_beyond_span(normal) && !keep_beyond_span(-normal)) return false;
    }
    return true;
  }

  bool keep_beyond_span(Vec3 outward) {
    const DifferenceCorner corner = furthest_along(outward);
    if (!(std::fabs(dot(outward, difference(corner) - difference(0))) > tie_)) return false;
    keep(corner);
    return true;
  }

  // A direction across the span of the first corners.
  Vec3 across_span(std::size_t count) const {
    if (count == 1) return {1, 0, 0};
    const Vec3 along = difference(1) - difference(0);
    if (count == 3) return unit(cross(along, difference(2) - difference(0)));
    const double x = std::fabs(along.x), y = std::fabs(along.y), z = std::fabs(along.z);
    return unit(cross(along, x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1}));
  }

  // How far a point is from the span of the first corners.
  double height_over_span(std::size_t count, Vec3 point) const {
    const Vec3 from = point - difference(0);
    if (count == 1) return norm(from);
    const Vec3 along = unit(difference(1) - difference(0));
    if (count == 2) return norm(cross(along, from));
    return dot(unit(cross(along, difference(2) - difference(0))), from);
  }

  // In doubles; false if these do not close the bounds.
  bool expand() {
    polytope_.start({difference(0), difference(1), difference(2), difference(3)}, tie_);
    for (int round = 0; round < kMostRounds; ++round) {
      const std::int32_t f = polytope_.nearest();
      const ExpandingPolytope::Plane plane = polytope_.plane(f);
      best_.lower = polytope_.height(f) - difference_error_;
      if (!std::isfinite(best_.lower)) return false;
      const DifferenceCorner corner = furthest_along(plane.normal);
      const double reached = dot(plane.normal, difference(corner));
      if (best_.upper - larger(best_.lower, 0) <= goal_) {
        if (reached + support_error_ - larger(best_.lower, 0) <= goal_) take_face(f);
        return true;
      }
      if (reached - plane.offset > tie_) {
        if (!polytope_.expand(f, difference(corner))) return false;
        keep(corner);
      } else if (!polytope_.is_refined(f)) {
        polytope_.refine(f);
      } else {
        return false;
      }
    }
    return true;
  }

  // The direction of the nearest face, and the points where the origin's projection is in it, or in another face of the
  // same plane: a facet of the difference has several where edges cross, and where a face has more than three corners.
  void take_face(std::int32_t nearest) {
    const Vec3 normal = polytope_.plane(nearest).normal;
    best_.direction = -normal;
    double innermost = -std::numeric_limits<double>::infinity(), widest = 0;
    for (std::int32_t f = 0; f < polytope_.face_count(); ++f) {
      if (!(polytope_.height(f) <= best_.upper + difference_error_)) continue;
      // A plane's height is a bound with all of its normal's error, times a distance of at least `lower`.
      const ExpandingPolytope::Plane& plane = polytope_.plane(f);
      const double turned = norm(plane.normal - normal);
      widest = larger(widest, turned + (plane.offset - polytope_.height(f)) / best_.lower);
      if (turned > kSamePlane) continue;
      const std::array<std::int32_t, 3>& corner = polytope_.corners(f);
      Vec3 point;
      double sum = 0, least = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 next = polytope_.point(corner[(i + 1) % 3]), last = polytope_.point(corner[(i + 2) % 3]);
        const double weight = dot(normal, cross(next, last));
        least = smaller(least, weight), sum += larger(weight, 0);
        point = point + larger(weight, 0) * w_.corners[at(corner[i])].body_a;
      }
      if (sum > 0 && least > innermost) innermost = least, best_.on_body_a = (1 / sum) * point;
    }
    best_.turn = std::sqrt(2 * (best_.upper - best_.lower) / best_.upper) + widest + kUnitRounding;
  }

  // Around the exact hull of all corners found. Its planes are known to double-double; it grows where it is nearest to
  // the origin until the bounds meet, or no vertex is beyond the nearest plane.
  void expand_exactly() {
    for (int round = 0; round < kMostExactRounds; ++round) {
      const std::optional<DifferenceCorner> corner = beyond_nearest_plane();
      if (!corner || best_.upper - larger(best_.lower, 0) <= goal_) return;
      keep(*corner);
    }
  }

  std::optional<DifferenceCorner> beyond_nearest_plane() {
    w_.points.clear();
    for (std::size_t i = 0; i < w_.corners.size(); ++i) w_.points.push_back(difference(i));
    if (affine_span(w_.points).dimension < 3) return std::nullopt;
    const TriangleSurface hull = quickhull(w_.points);
    std::optional<FinePlane> nearest;
    for (const Triangle& triangle : hull.triangles) {
      const FinePlane plane(w_.points[at(triangle[0])], w_.points[at(triangle[1])], w_.points[at(triangle[2])]);
      if (!nearest || plane.height < nearest->height) nearest = plane;
    }
    best_.lower = larger(best_.lower, nearest->height - difference_error_);
    const DifferenceCorner corner = furthest_along(nearest->normal);
    return is_kept(corner) ? std::nullopt : std::optional(corner);
  }
};

}  // namespace

HullDepth hull_depth(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start,
                     PairCounters& counters, bool doubles) {
  return DepthSearch(body_a, body_b, counters).run(start, doubles);
}

}  // namespace plannercheck
