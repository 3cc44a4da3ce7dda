#include "narrow_phase/distance.hpp"

namespace plannercheck {
namespace {

// Bodies are off rigid by at most 3.6e-6, so they stretch by half of that. kBallRounding: the rounding of a ball's
// centre and of distances, relative to their operands. A norm whose squares underflow errs by less than kTrustedLength.
constexpr double kDistanceStretch = 1 + 4e-6, kBallRounding = 64 * 0x1p-53;

double total_inflation_radius(const PosedPolytope& a, const PosedPolytope& b) {
  return a.body->inflation_radius + b.body->inflation_radius;
}

Vec3 posed_centre(const PosedPolytope& posed) { return posed.pose.apply(posed.body->centre); }

double extent(const Polytope& body) { return body.radius + body.inflation_radius; }

// Directions along which the guest may leave the host; keeps the best one found.
class WayOut {
 public:
  WayOut(const PosedPolytope& guest, const PosedPolytope& host, PairCounters& counters)
      : guest_(guest), host_(host), counters_(counters) {}

  // The hulls' penetration is at most `depth`: moving the guest that far along `direction` separates them.
  double depth = std::numeric_limits<double>::infinity();
  Vec3 direction, deepest;

  void run() {
    try_direction(posed_centre(guest_) - posed_centre(host_));
    try_axes(guest_.pose), try_axes(host_.pose);
    for (const Vec3& q : host_.body->polar.points) try_direction(host_.pose.rotate(q));
    for (const Vec3& q : guest_.body->polar.points) try_direction(-guest_.pose.rotate(q));
  }

 private:
  const PosedPolytope &guest_, &host_;
  PairCounters& counters_;

  void try_axes(const Pose& pose) {
    for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      try_direction(pose.rotate(axis));
      try_direction(-pose.rotate(axis));
    }
  }

  void try_direction(Vec3 d) {
    if (!(norm_max(d) > 0) || !std::isfinite(norm_max(d))) return;
    d = unit(d);
    const LowestDifference found = lowest_difference(guest_, host_, d, counters_);
    if (-found.height < depth) depth = -found.height, direction = d, deepest = found.guest_vertex;
  }
};

PairDistance hulls_overlap(const PosedPolytope& guest, const PosedPolytope& host, double inflation_radius,
                           PairCounters& counters) {
  WayOut way(guest, host, counters);
  way.run();
  const double depth = larger(way.depth, 0) + inflation_radius;
  const Vec3 point = way.deepest - guest.body->inflation_radius * way.direction;
  return {true, -depth, -depth, point, point + depth * way.direction, way.direction};
}

PairDistance between_hulls(const PosedPolytope& guest, const PosedPolytope& host, const HullDistance& found,
                           bool overlap) {
  const double inflation_radius = total_inflation_radius(guest, host);
  PairDistance out{
      overlap,        found.lower - inflation_radius, found.upper - inflation_radius, found.on_guest, found.on_host,
      found.direction};
  if (overlap) {
    out.lower = out.upper = smaller(out.lower, 0);
  } else {
    // The exact verdict says that there is a gap, however small.
    out.upper = larger(out.upper, std::numeric_limits<double>::denorm_min());
    out.lower = larger(out.lower, 0);
  }
  const Vec3 apart = found.on_guest - found.on_host;
  const Vec3 d = norm_max(apart) > 0 ? unit(apart) : found.direction;
  out.on_guest = out.on_guest - guest.body->inflation_radius * d;
  out.on_host = out.on_host + host.body->inflation_radius * d;
  return out;
}

DistanceGoal goal_for(const PosedPolytope& guest, const PosedPolytope& host, double limit) {
  const double inflation_radius = total_inflation_radius(guest, host);
  const double size = larger(extent(*guest.body), extent(*host.body));
  return {kDistanceError, inflation_radius, kLeastOfSize * size, limit + inflation_radius};
}

}  // namespace

double ball_gap(const PosedPolytope& guest, const PosedPolytope& host) {
  const Vec3 a = posed_centre(guest), b = posed_centre(host);
  const double radii =
      (guest.body->radius + host.body->radius) * kDistanceStretch + total_inflation_radius(guest, host);
  const double reach = guest.body->origin_radius + host.body->origin_radius + norm_1(a) + norm_1(b) + radii;
  return norm(a - b) - radii - (kBallRounding * reach + kTrustedLength);
}

double convex_bound(const PosedPolytope& guest, const PosedPolytope& host, int rounds, PairCounters& counters) {
  DistanceGoal goal = goal_for(guest, host, std::numeric_limits<double>::infinity());
  goal.rounds = rounds;
  const HullDistance found = hull_distance(guest, host, posed_centre(guest) - posed_centre(host), goal, counters);
  const double balls = ball_gap(guest, host);
  return found.lower > 0 ? larger(balls, found.lower - goal.inflation_radius * (1 + 0x1p-50)) : balls;
}

PairDistance convex_distance(const PosedPolytope& guest, const PosedPolytope& host, double limit,
                             PairCounters& counters) {
  const DistanceGoal goal = goal_for(guest, host, limit);
  const Vec3 hint = posed_centre(guest) - posed_centre(host);
  HullDistance found = hull_distance(guest, host, hint, goal, counters);
  bool overlap = false;
  if (!(found.lower > goal.inflation_radius * (1 + 0x1p-48))) {
    const bool guest_hosts = choose_host(*guest.body, *host.body) == 0;
    PairOptions of_hulls;
    of_hulls.dents = false;
    overlap = test_pair(guest_hosts ? host : guest, guest_hosts ? guest : host, of_hulls, nullptr, counters).shared;
  }
  const bool in_doubt = !goal.met(found) && !(overlap && found.start.count == 4);
  if (in_doubt) found = hull_distance_double_double(guest, host, found, goal, counters);
  if (overlap && !(found.lower > 0)) return hulls_overlap(guest, host, goal.inflation_radius, counters);
  return between_hulls(guest, host, found, overlap);
}

}  // namespace plannercheck
