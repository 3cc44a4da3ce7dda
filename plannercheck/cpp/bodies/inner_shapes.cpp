#include "bodies/inner_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "bodies/polytope.hpp"

namespace plannercheck {
namespace {

// A facet's distance from a point is (1 − q·y) / |q|, with y the point less the centre, |y| at most 4 radii. q errs by
// 4u of its length, the product by 6u |q| |y|; the difference, 1 / |q| <= radius, the quotient and y by a few u each.
constexpr double kFacetError = 128 * 0x1p-53;
// Lengths of polar points for which squares neither overflow nor lose bits to underflow.
constexpr double kShortest = 1e-150, kLongest = 1e150;

// This many points inside are tried as centres of balls, out of those spread over the body's box (measured: 96 of 256
// settle 2 % fewer collisions, 192 of 1,024 no more).
constexpr std::size_t kTriedCentres = 128;
constexpr int kSpreadPoints = 512;

// How far a box grows in one step, as parts of the body's edges.
constexpr double kFirstStep = 1.0 / 8, kLastStep = 1.0 / 256;
// How round a box may be, in parts of the largest ball's radius. Round boxes fill cylinders and links best.
constexpr std::array<double, 2> kRoundings{0, 0.95};

// The half-spaces whose intersection is the body's hull.
class Facets {
 public:
  explicit Facets(const Polytope& body) : body_(body), room_(kFacetError * body.radius) {
    inverses_.reserve(body.polar.points.size());
    for (const Vec3& q : body.polar.points) {
      const double length = norm(q);
      are_known_ &= length > kShortest && length < kLongest;
      inverses_.push_back(1 / length);
    }
  }

  // If false, the facets' distances are not known.
  bool are_known() const { return are_known_; }

  // The radius of the largest ball around a point inside; not positive if no ball fits.
  double radius_around(Vec3 point) const {
    const Vec3 y = point - body_.centre;
    double least = body_.radius;
    for (std::size_t k = 0; k < inverses_.size() && least > 0; ++k) {
      least = smaller(least, (1 - dot(body_.polar.points[k], y)) * inverses_[k]);
    }
    return least - room_;
  }

  bool hold(const InnerBox& box) const {
    const Vec3 low = box.low - body_.centre, high = box.high - body_.centre;
    const double radius = box.radius + room_;
    for (std::size_t k = 0; k < inverses_.size(); ++k) {
      const Vec3 q = body_.polar.points[k];
      const double most =
          larger(q.x * low.x, q.x * high.x) + larger(q.y * low.y, q.y * high.y) + larger(q.z * low.z, q.z * high.z);
      if (!((1 - most) * inverses_[k] >= radius)) return false;
    }
    return true;
  }

 private:
  const Polytope& body_;
  double room_;
  bool are_known_ = true;
  std::vector<double> inverses_;
};

// Spread evenly over the body's box: multiples, modulo 1, of g^-1, g^-2 and g^-3 with g^4 = g + 1.
Vec3 spread_point(const Polytope& body, int k) {
  constexpr std::array<double, 3> kStride{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const auto part = [&](std::size_t i) {
    const double x = 0.5 + (k + 1) * kStride[i];
    return x - std::floor(x);
  };
  const Vec3 edges = body.high - body.low;
  return body.low + Vec3{part(0) * edges.x, part(1) * edges.y, part(2) * edges.z};
}

// Empty if the body is about as thin as rounding.
std::vector<InnerBall> tried_balls(const Polytope& body, const Facets& facets) {
  std::vector<InnerBall> balls;
  const auto try_around = [&](Vec3 point) {
    const double radius = facets.radius_around(point);
    if (radius > 0) balls.push_back({point, radius});
  };
  try_around(body.centre);
  for (int k = 0; k < kSpreadPoints && balls.size() < kTriedCentres; ++k) try_around(spread_point(body, k));
  return balls;
}

// Greedily picks the balls that hold most centres not yet covered.
std::vector<InnerBall> covering(const std::vector<InnerBall>& balls) {
  std::vector<InnerBall> chosen, left = balls;
  const auto holds = [](const InnerBall& ball, const InnerBall& other) {
    const Vec3 d = other.centre - ball.centre;
    return dot(d, d) < ball.radius * ball.radius;
  };
  while (chosen.size() < kInnerBalls && !left.empty()) {
    const InnerBall* best = nullptr;
    std::ptrdiff_t most = -1;
    for (const InnerBall& ball : balls) {
      const auto held = std::count_if(left.begin(), left.end(), [&](const InnerBall& b) { return holds(ball, b); });
      if (held > most) best = &ball, most = held;
    }
    chosen.push_back(*best);
    if (most == 0) break;
    const auto rest = std::remove_if(left.begin(), left.end(), [&](const InnerBall& b) { return holds(*best, b); });
    left.erase(rest, left.end());
  }
  return chosen;
}

Vec3 along_axis(std::size_t axis, double length) {
  return {axis == 0 ? length : 0, axis == 1 ? length : 0, axis == 2 ? length : 0};
}

// Grows the box on all six sides in turn, in ever smaller steps.
InnerBox grown(const Facets& facets, const Polytope& body, InnerBox box) {
  const Vec3 edges = body.high - body.low;
  const auto grow = [&](std::size_t side, double step) {
    const std::size_t axis = side / 2;
    const Vec3 by = along_axis(axis, step * edges[static_cast<int>(axis)]);
    const InnerBox next =
        side % 2 == 0 ? InnerBox{box.low - by, box.high, box.radius} : InnerBox{box.low, box.high + by, box.radius};
    const bool differs = !(next.low == box.low && next.high == box.high);  // false if rounding swallows the step
    const bool held = differs && facets.hold(next);
    if (held) box = next;
    return held;
  };
  for (double step = kFirstStep; step >= kLastStep; step /= 2) {
    std::array<bool, 6> grows;
    grows.fill(true);
    while (std::find(grows.begin(), grows.end(), true) != grows.end()) {
      for (std::size_t side = 0; side < grows.size(); ++side) grows[side] = grows[side] && grow(side, step);
    }
  }
  return box;
}

double volume(const InnerBox& box) {
  const Vec3 d = box.high - box.low;
  const double more = 2 * box.radius;
  return (d.x + more) * (d.y + more) * (d.z + more);
}

InnerBox largest_box(const Polytope& body, const Facets& facets, const std::vector<InnerBall>& balls) {
  const auto is_smaller = [](const InnerBall& a, const InnerBall& b) { return a.radius < b.radius; };
  const InnerBall ball = *std::max_element(balls.begin(), balls.end(), is_smaller);
  InnerBox best{ball.centre, ball.centre, 0};
  for (const double rounding : kRoundings) {
    const InnerBox box = grown(facets, body, {ball.centre, ball.centre, rounding * ball.radius});
    if (volume(box) > volume(best)) best = box;
  }
  return best;
}

// Balls of a point, or evenly spaced on the segment between the two vertices.
std::vector<InnerBall> balls_on_segment(const Polytope& body) {
  std::vector<InnerBall> balls;
  const std::size_t count = body.dimension == 0 ? 1 : kInnerBalls;
  for (std::size_t k = 0; k < count; ++k) {
    const double t = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
    balls.push_back({(1 - t) * body.inner.points.front() + t * body.inner.points.back(), 0});
  }
  return balls;
}

// Whether the body equals the box around it: a box, a point, or a segment along an axis.
bool is_its_box(const Polytope& body) {
  const Vec3 edges = body.high - body.low;
  const int flat = (edges.x == 0 ? 1 : 0) + (edges.y == 0 ? 1 : 0) + (edges.z == 0 ? 1 : 0);
  return body.is_box != 0 || flat >= 2;
}

}  // namespace

InnerShapes find_inner_shapes(const Polytope& body) {
  InnerShapes shapes;
  if (body.solid) return shapes;
  if (is_its_box(body)) shapes.box = InnerBox{body.low, body.high, 0};
  if (!body.has_polar()) {
    if (body.dimension <= 1) shapes.balls = balls_on_segment(body);
    return shapes;
  }
  const Facets facets(body);
  if (!facets.are_known()) return shapes;
  const std::vector<InnerBall> balls = tried_balls(body, facets);
  if (balls.empty()) return shapes;
  shapes.balls = covering(balls);
  if (!shapes.box) shapes.box = largest_box(body, facets, balls);
  return shapes;
}

}  // namespace plannercheck
