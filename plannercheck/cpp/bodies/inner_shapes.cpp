#include "bodies/inner_shapes.hpp"

#include <algorithm>
#include <limits>

#include "bodies/inner_shape_search.hpp"
#include "bodies/polytope.hpp"
#include "bodies/solid_interior.hpp"

namespace plannercheck {
namespace {

// A facet's distance from a point is (1 − q·y) / |q|, with y the point less the centre, |y| at most 4 radii. q errs by
// 4u of its length, the product by 6u |q| |y|; the differences, 1 / |q| <= radius, the quotient and y by a few u each.
constexpr double kFacetError = 128 * 0x1p-53;
// With 16 vertices 43 of 100 colliding pairs of pr2's links are told by samples, with 64 of them 48: hardly worth their
// time, which pairs that are apart wait for (measured).
constexpr std::size_t kSampleBlocks = 3;
// Lengths of polar points for which squares neither overflow nor lose bits to underflow.
constexpr double kShortest = 1e-150, kLongest = 1e150;

// The half-spaces whose intersection is the body's hull; of a solid, those less its dents.
class Facets {
 public:
  explicit Facets(const Polytope& body) : body_(body), heights_(facet_heights(body)), room_(kFacetError * body.radius) {
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
      least = smaller(least, (heights_[k] - dot(body_.polar.points[k], y)) * inverses_[k]);
    }
    return least - room_;
  }

  bool holds(const InnerBox& box) const {
    const Vec3 low = box.low - body_.centre, high = box.high - body_.centre;
    const double radius = box.radius + room_;
    for (std::size_t k = 0; k < inverses_.size(); ++k) {
      const Vec3 q = body_.polar.points[k];
      const double most =
          larger(q.x * low.x, q.x * high.x) + larger(q.y * low.y, q.y * high.y) + larger(q.z * low.z, q.z * high.z);
      if (!((heights_[k] - most) * inverses_[k] >= radius)) return false;
    }
    return true;
  }

 private:
  const Polytope& body_;
  std::vector<double> heights_;  // of q·y
  double room_;
  bool are_known_ = true;
  std::vector<double> inverses_;
};

// Empty if the body is about as thin as rounding.
std::vector<InnerBall> tried_balls(const Polytope& body, const Facets& facets) {
  std::vector<InnerBall> balls;
  const auto try_around = [&](Vec3 point) {
    const double radius = facets.radius_around(point);
    if (radius > 0) balls.push_back({point, radius});
  };
  try_around(body.centre);
  for (int k = 0; k < kSpreadPoints && balls.size() < kTriedCentres; ++k)
    try_around(spread_point(body.low, body.high, k));
  return balls;
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

InnerShapes shapes_in_hull(const Polytope& body) {
  InnerShapes shapes;
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
  if (!shapes.box) shapes.box = largest_box(facets, body.high - body.low, balls);
  return shapes;
}

// Points that are far from each other: each is the furthest from those before it, the first from the middle.
std::vector<Vec3> spread_over(const std::vector<Vec3>& points, Vec3 middle, std::size_t count) {
  std::vector<double> squares(points.size(), std::numeric_limits<double>::infinity());
  std::vector<Vec3> chosen;
  Vec3 last = middle;
  while (chosen.size() < std::min(count, points.size())) {
    std::size_t furthest = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec3 way = points[k] - last;
      squares[k] = chosen.size() == 1 ? dot(way, way) : smaller(squares[k], dot(way, way));
      if (squares[k] > squares[furthest]) furthest = k;
    }
    chosen.push_back(last = points[furthest]);
  }
  return chosen;
}

// `points`: of the body.
std::vector<SampleBlock> samples_of(const Polytope& body, const std::vector<Vec3>& points,
                                    const std::vector<InnerBall>& inner_balls) {
  std::vector<InnerBall> balls = inner_balls;
  for (const Vec3& p : spread_over(points, 0.5 * (body.low + body.high), kSampleBlocks * kSamples - balls.size()))
    balls.push_back({p, 0});
  std::vector<SampleBlock> blocks((balls.size() + kSamples - 1) / kSamples);
  for (std::size_t k = 0; k < kSamples * blocks.size(); ++k) {
    const auto& [c, radius] = balls[std::min(k, balls.size() - 1)];
    const std::array<double, 4> entries{c.x, c.y, c.z, radius};
    for (std::size_t i = 0; i < 4; ++i) blocks[k / kSamples].entry[i][k % kSamples] = entries[i];
  }
  return blocks;
}

}  // namespace

InnerShapes find_inner_shapes(const Polytope& body) {
  const std::vector<Vec3>* points = &body.inner.points;
  InnerShapes shapes;
  switch (body.kind()) {
    case Kind::kHull:
      shapes = shapes_in_hull(body);
      break;
    case Kind::kSolid:
      shapes = body.dents.are_known() ? shapes_in_hull(body) : inner_shapes_of(body.as<Solid>());
      points = &body.as<Solid>().points;
      break;
    case Kind::kPartSet:
    case Kind::kHalfSpace:
      return {};
  }
  shapes.samples = samples_of(body, *points, shapes.balls);
  return shapes;
}

}  // namespace plannercheck
