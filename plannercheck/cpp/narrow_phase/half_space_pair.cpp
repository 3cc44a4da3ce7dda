#include "narrow_phase/half_space_pair.hpp"

#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "bodies/part_body.hpp"
#include "math/dyadic.hpp"
#include "narrow_phase/support.hpp"

namespace plannercheck {
namespace {

// u = 2^-53, n = normal, reach = |p| + |s|_1 + |t|_1 of a vertex p posed by A p + s and the half-space's t. Entries of
// adj(M) err by 3u, g by 6u |n| an entry more, 16u |n| as a vector; turning −g into the body's frame by 5.2u |g|, which
// moves the lowest vertex by 10.4u |g| |p|, a scan by 14u |g| |p|; posing a vertex and taking t off by 7.2u of the
// reach, the product by 5.2u |g|: 53u |n| reach. det M errs by 12u, times the offset, product and difference by 2u.
constexpr double kHeightError = 128 * 0x1p-53;
// Lengths, radii, their products and sums: fewer than ten operations.
constexpr double kPlaneReachRounding = 16 * 0x1p-53;
// Balls around bodies off rigid by at most 3.6e-6, which stretch by half of that.
constexpr double kBallStretch = 1 + 4e-6;

// Between these the least height of all vertices of a hull over a plane is, m; and a vertex as low as far as is known.
struct LeastHeight {
  double lower, upper;
  Vec3 vertex;
};

// How far the vertices of a body's hull are over a posed half-space's plane, times |g|.
class Heights {
 public:
  Heights(const PosedPolytope& half_space, const PosedPolytope& body)
      : half_space_(half_space),
        body_(body),
        plane_(posed_plane<double, Vec3>(half_space.body->as<HalfSpace>(), half_space.pose)) {
    const Vec3 t = half_space.pose.translation();
    const HalfSpace& h = half_space.body->as<HalfSpace>();
    const double reach = body.body->origin_radius + norm_1(body.pose.translation()) + norm_1(t);
    error_ = kHeightError * (norm_1(h.normal) * reach + std::fabs(h.offset)) + kDenormalError;
    length_ = norm(plane_.normal);
    radius_ = body.body->inflation_radius + half_space.body->inflation_radius;
  }

  Vec3 normal() const { return plane_.normal; }
  double length() const { return length_; }
  double error() const { return error_; }
  double radius() const { return radius_; }
  // What a height has to exceed: surely no less, and surely no more.
  double most() const { return radius_ * length_ * (1 + kPlaneReachRounding) + error_; }
  double least() const { return radius_ * length_ * (1 - kPlaneReachRounding) - error_; }

  // Whether the ball around the body keeps it over the plane.
  bool ball_is_over() const {
    const double radius = (body_.body->radius * kBallStretch + radius_) * length_ * (1 + kPlaneReachRounding);
    return of(body_.body->centre) > radius + 2 * error_;
  }

  double of(Vec3 point) const {
    return dot(plane_.normal, body_.pose.apply(point) - half_space_.pose.translation()) - plane_.offset;
  }

  // The vertex nearest to the plane, up to the error.
  Vec3 lowest(PairCounters& counters) const {
    ++counters.queries_a;
    const Vec3 against = -body_.pose.rotate_back(plane_.normal);
    return body_.body->inner.points[at(extreme(body_.body->inner, against, counters.queries))];
  }

  // Whether some vertex is no further over the plane than the radii, exactly. Only those within the error of the
  // lowest one, or of the radii, can tell.
  bool shares_exactly() const {
    const double bound = most();
    const ExactPlane plane = exact_plane();
    const Dyadic radius = Dyadic(body_.body->inflation_radius) + Dyadic(half_space_.body->inflation_radius);
    const Dyadic most_square = radius * radius * dot(plane.normal, plane.normal);
    for (const Vec3& p : body_.body->inner.points) {
      if (of(p) > bound + error_) continue;
      const Dyadic height = exactly(p, plane);
      if (height.sign() <= 0 || (most_square - height * height).sign() >= 0) return true;
    }
    return false;
  }

  LeastHeight least_height(PairCounters& counters) const {
    const Vec3 vertex = lowest(counters);
    const double inverse = 1 / length_, height = of(vertex);
    const double rounding = kPlaneReachRounding * (std::fabs(height) * inverse);
    const LeastHeight found{(height - error_) * inverse - rounding, (height + error_) * inverse + rounding, vertex};
    const double size = body_.body->radius + radius_;
    const bool is_enough =
        found.upper - found.lower <= kDistanceError * larger(found.lower - radius_, kLeastOfSize * size);
    return is_enough ? found : least_height_exactly(height);
  }

 private:
  using ExactPlane = PlaneInWorld<Dyadic, DyadicVec3>;

  const PosedPolytope &half_space_, &body_;
  PlaneInWorld<double, Vec3> plane_;
  double error_, length_, radius_;

  ExactPlane exact_plane() const {
    return posed_plane<Dyadic, DyadicVec3>(half_space_.body->as<HalfSpace>(), half_space_.pose);
  }

  Dyadic exactly(Vec3 point, const ExactPlane& plane) const {
    const DyadicVec3 from = apply_exactly(body_.pose, point) - DyadicVec3(half_space_.pose.translation());
    return dot(plane.normal, from) - plane.offset;
  }

  // Far from the origin, where heights in doubles cancel. `height`: in doubles, of the lowest vertex as far as they
  // tell. It is off by the error, and so is that of any other vertex.
  LeastHeight least_height_exactly(double height) const {
    const ExactPlane plane = exact_plane();
    std::optional<Dyadic> least;
    LeastHeight found;
    for (const Vec3& p : body_.body->inner.points) {
      if (of(p) > height + 2 * error_) continue;
      const Dyadic of_p = exactly(p, plane);
      if (!least || (of_p - *least).sign() < 0) least = of_p, found.vertex = p;
    }
    const Vec3 normal{plane.normal.x.to_double(), plane.normal.y.to_double(), plane.normal.z.to_double()};
    const double rounded = least->to_double() / norm(normal);
    const double rounding = kPlaneReachRounding * (std::fabs(rounded) + radius_) + kDenormalError;
    found.lower = rounded - rounding, found.upper = rounded + rounding;
    return found;
  }
};

bool hull_meets_half_space(const PosedPolytope& half_space, const PosedPolytope& body, PairCounters& counters) {
  const Heights heights(half_space, body);
  if (heights.ball_is_over()) return false;
  const double height = heights.of(heights.lowest(counters));
  if (height > heights.most()) return false;
  return height < heights.least() || heights.shares_exactly();
}

// A proved lower bound of how far all vertices of a hull are over a plane, m.
double hull_height(const PosedPolytope& half_space, const PosedPolytope& body, PairCounters& counters) {
  const Heights heights(half_space, body);
  const double inverse = 1 / heights.length(), height = heights.of(heights.lowest(counters));
  return (height - heights.error()) * inverse - kPlaneReachRounding * (std::fabs(height) * inverse);
}

// By how much a part's radius exceeds that of its body, of which it is a part.
double more_radius(const PosedPolytope& part, const PosedPolytope& body) {
  const double more = part.body->inflation_radius - body.body->inflation_radius;
  return more * (1 + kPlaneReachRounding) + kPlaneReachRounding * part.body->inflation_radius;
}

// As PartSet::any_part; of another body its hull, whose place is −1.
template <class Visit>
void each_part(const PosedPolytope& body, Visit visit) {
  if (!body.body->traits().has_parts) return static_cast<void>(visit(body, -1));
  PartBody filled;
  body.body->as<PartSet>().any_part([&](const PartShape& part, std::size_t place) {
    filled.fill(part, body.body->inflation_radius);
    return visit(PosedPolytope{&filled.body(), body.pose}, static_cast<std::int32_t>(place));
  });
}

// The body's place is `a`.
PartContact body_meets_half_space(const PosedPolytope& half_space, const PosedPolytope& body, PairCounters& counters) {
  PartContact found;
  if (Heights(half_space, body).ball_is_over()) return found;
  each_part(body, [&](const PosedPolytope& part, std::int32_t place) {
    if (hull_meets_half_space(half_space, part, counters)) found = {true, place, -1};
    return found.shared;
  });
  return found;
}

// From the half-space to the body.
PairDistance hull_distance_over(const PosedPolytope& half_space, const PosedPolytope& body, PairCounters& counters) {
  const Heights heights(half_space, body);
  const Vec3 normal = (1 / heights.length()) * heights.normal();
  const LeastHeight least = heights.least_height(counters);
  PairDistance out;
  out.overlap = hull_meets_half_space(half_space, body, counters);
  out.lower = least.lower - heights.radius();
  out.upper = least.upper - heights.radius();
  if (out.overlap) {
    out.lower = smaller(out.lower, 0), out.upper = smaller(out.upper, 0);
  } else {
    out.upper = larger(out.upper, std::numeric_limits<double>::denorm_min());
    out.lower = larger(out.lower, 0);
  }
  const Vec3 lowest = body.pose.apply(least.vertex);
  const double height = (least.lower + least.upper) / 2;
  out.on_body_a = lowest - body.body->inflation_radius * normal;
  out.on_body_b = lowest - (height - half_space.body->inflation_radius) * normal;
  out.direction = normal;
  return out;
}

PairDistance distance_over(const PosedPolytope& half_space, const PosedPolytope& body, PairCounters& counters,
                           const PartVisitor* visit) {
  PairDistance least = PairDistance::nothing_near();
  each_part(body, [&](const PosedPolytope& part, std::int32_t) {
    const PairDistance found = hull_distance_over(half_space, part, counters);
    if (visit != nullptr) visit->show(part, half_space, found);
    least.take(found);
    return false;
  });
  return least;
}

}  // namespace

PartContact half_space_contact(const PosedPolytope& a, const PosedPolytope& b, PairCounters& counters) {
  if (a.body->traits().is_bounded) return body_meets_half_space(b, a, counters);
  const PartContact found = body_meets_half_space(a, b, counters);
  return {found.shared, found.b, found.a};
}

PairDistance half_space_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, PairCounters& counters,
                                 const PartVisitor* visit) {
  if (!body_b.body->traits().is_bounded) return distance_over(body_b, body_a, counters, visit);
  PairDistance out = distance_over(body_a, body_b, counters, visit);
  std::swap(out.on_body_a, out.on_body_b);
  out.direction = -out.direction;
  return out;
}

double height_over(const PosedPolytope& half_space, const PosedPolytope& body, PairCounters& counters) {
  double least = kNoLimit;
  each_part(body, [&](const PosedPolytope& part, std::int32_t place) {
    least = smaller(least, hull_height(half_space, part, counters) - (place < 0 ? 0 : more_radius(part, body)));
    return false;
  });
  return least;
}

}  // namespace plannercheck
