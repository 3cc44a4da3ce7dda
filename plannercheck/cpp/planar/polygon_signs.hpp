// Exact signs about two posed polygons in the plane, for the algorithm of polygon_test.cpp.
//
// In: vertices as ordered arrays, poses x -> M x + t, all with the exact values of their doubles. Out: signs of
// polynomials of these numbers. Each sign is computed in doubles with a proved bound; if the bound is too wide, in
// double-double; then in dyadic numbers. Nothing is prepared and no array is copied.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "math/dyadic.hpp"
#include "math/predicates.hpp"

namespace plannercheck {

// Rows of x, y in the order of the boundary, either way round.
struct PlanarPolygon {
  const double* vertices = nullptr;
  std::size_t count = 0;

  double x(std::size_t k) const { return vertices[2 * k]; }
  double y(std::size_t k) const { return vertices[2 * k + 1]; }
};

// x -> M x + t, row by row: m00 m01 tx m10 m11 ty.
struct PlanarPose {
  std::array<double, 6> m{1, 0, 0, 0, 1, 0};
};

struct PosedPolygon {
  PlanarPolygon shape;
  PlanarPose pose;
};

// The arithmetic with which signs start.
enum class Precision { kDoubles, kDoubleDouble, kExact };

struct PlanarCounters {
  long rounds = 0;         // of the algorithm: each prunes one chain or ends
  long vertices = 0;       // read, with repetitions
  long double_double = 0;  // signs that the filter in doubles left open
  long exact = 0;          // signs that double-double left open, too
};

inline PlanarCounters& operator+=(PlanarCounters& sum, const PlanarCounters& more) {
  sum.rounds += more.rounds, sum.vertices += more.vertices;
  sum.double_double += more.double_double, sum.exact += more.exact;
  return sum;
}

struct NotFiniteError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

// A vertex of A relative to the origin of B's frame, along the axes of the world, with the sums of the
// absolute values of its coordinates' terms; these are infinite if too large for a filter.
struct PointOfA {
  std::size_t index;
  double x, y, size_x, size_y;
};

// The line through two vertices of B, directed so that B is on its left; sizes as above.
struct LineOfB {
  std::size_t from, to;
  double dx, dy, size_dx, size_dy;  // M (to - from), turned round if B runs clockwise
  double x, y, size_x, size_y;      // M (to - from), reversed if B runs clockwise
};

// How far a point is on B's side of a line, times the line's length; the error is infinite where a filter in
// doubles cannot be trusted.
struct Side {
  double value, error;
};

// Non-negative weights of two lines; A is pruned along their mixed side function.
struct LineWeights {
  double first = 1, second = 0;
  std::optional<std::array<Dyadic, 2>> exact;  // replaces both where no doubles could be certified
};

// The gradient of the mixed side function w_i i(p) + w_j j(p) along A's own axes, and the sums of the absolute
// values of its terms; infinite or NaN where doubles cannot be trusted.
struct Slope {
  const LineWeights& weights;
  const LineOfB &i, &j;
  double x, y, size_x, size_y;
};

namespace planar_detail {

// A filter is trusted if the sum of the absolute values of all terms and their factors is in this range: products of
// four sides then neither overflow nor lose to underflow what the bounds do not count.
inline constexpr double kSmallestSize = 1e-100, kLargestSize = 1e45;
// Larger coordinates are not trusted either: another factor of a trusted product may have lost bits to underflow.
inline constexpr double kLargestCoordinate = 1e100;

// A side is the cross product of D = M (to - from) and X - Y with X = M p + t, Y = M from. D: difference, product, sum,
// 3u of its size; X: t is a rounded difference (u), product, two sums, 4u; Y: product, sum, 2u; X - Y: 1u; product and
// difference of the cross product: 2u. Together 10u + O(u^2) of the permanent, whose own rounding 12u covers as well.
inline constexpr double kSideBound = 12 * kRoundoff;

// A climb is the product of g = M^T (w_i n_i + w_j n_j), n the lines' normals, and a difference of vertices. n: 3u of
// its size as above; weight and sum: 2u; M^T: 2u; difference, product, sum: 3u. Together 10u + O(u^2) of the permanent.
inline constexpr double kCompareBound = 12 * kRoundoff;
// Two products of sides and their sum, times the sum of their absolute values: product and sum, 2u.
inline constexpr double kMixedError = 3 * kRoundoff;

// A cross product of two differences of vertices, times the sum of its terms' absolute values: two differences, product
// and difference, 4u.
inline constexpr double kCrossError = 6 * kRoundoff;

inline constexpr double kSmallestError = kCompareBound * kSmallestSize, kLargestError = kCompareBound * kLargestSize;

// A sum of positive terms that are bounds is itself computed with at most 16 roundings.
inline constexpr double kSlack = 1 + 0x1p-48;

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

inline bool is_usable(double coordinates) { return coordinates < kLargestCoordinate; }

}  // namespace planar_detail

class PlanarSigns {
 public:
  // `turn`: 1 if B's vertices run counter-clockwise, -1 if clockwise.
  PlanarSigns(const PosedPolygon& body_a, const PosedPolygon& body_b, int turn, Precision first,
              PlanarCounters& counters)
      : body_a_(body_a),
        body_b_(body_b),
        turn_(turn),
        first_(first),
        side_bound_(first == Precision::kDoubles ? planar_detail::kSideBound : planar_detail::kInfinite),
        compare_bound_(first == Precision::kDoubles ? planar_detail::kCompareBound : planar_detail::kInfinite),
        offset_x_(body_a.pose.m[2] - body_b.pose.m[2]),
        offset_y_(body_a.pose.m[5] - body_b.pose.m[5]),
        counters_(counters) {}

  PointOfA point(std::size_t index) const {
    ++counters_.vertices;
    const auto& m = body_a_.pose.m;
    const double x = body_a_.shape.x(index), y = body_a_.shape.y(index);
    const double xx = m[0] * x, xy = m[1] * y, yx = m[3] * x, yy = m[4] * y;
    PointOfA point{index, xx + xy + offset_x_, yx + yy + offset_y_,
                   std::fabs(xx) + std::fabs(xy) + std::fabs(offset_x_),
                   std::fabs(yx) + std::fabs(yy) + std::fabs(offset_y_)};
    if (!planar_detail::is_usable(point.size_x + point.size_y)) point.size_x = point.size_y = planar_detail::kInfinite;
    return point;
  }

  LineOfB line(std::size_t from, std::size_t to) const {
    counters_.vertices += 2;
    const auto& m = body_b_.pose.m;
    const double x = body_b_.shape.x(from), y = body_b_.shape.y(from);
    const double vx = body_b_.shape.x(to) - x, vy = body_b_.shape.y(to) - y;
    const double dxx = m[0] * vx, dxy = m[1] * vy, dyx = m[3] * vx, dyy = m[4] * vy;
    const double xx = m[0] * x, xy = m[1] * y, yx = m[3] * x, yy = m[4] * y;
    LineOfB line{from,
                 to,
                 turn_ * (dxx + dxy),
                 turn_ * (dyx + dyy),
                 std::fabs(dxx) + std::fabs(dxy),
                 std::fabs(dyx) + std::fabs(dyy),
                 xx + xy,
                 yx + yy,
                 std::fabs(xx) + std::fabs(xy),
                 std::fabs(yx) + std::fabs(yy)};
    if (!planar_detail::is_usable(line.size_dx + line.size_dy + line.size_x + line.size_y)) {
      line.size_dx = line.size_dy = planar_detail::kInfinite;
    }
    return line;
  }

  Side side(const LineOfB& line, const PointOfA& point) const {
    const double size = permanent(line, point);
    const bool trusted = size > planar_detail::kSmallestSize && size < planar_detail::kLargestSize;
    const double value = line.dx * (point.y - line.y) - line.dy * (point.x - line.x);
    return {value, trusted ? side_bound_ * size : planar_detail::kInfinite};
  }

  // 1 if `point` is beyond a line, off B's side, else 0.
  unsigned is_beyond(const Side& side, const LineOfB& line, const PointOfA& point) const {
    if (std::fabs(side.value) > side.error) return side.value < 0;
    return finer_sign(line, point) < 0;
  }

  // Sign of i(a) j(b) - i(b) j(a), where i and j are the sides of two points relative to two lines.
  int mixed(const LineOfB& i, const LineOfB& j, const PointOfA& a, const PointOfA& b, const Side& ia, const Side& ib,
            const Side& ja, const Side& jb) const {
    const double plus = ia.value * jb.value, minus = ib.value * ja.value;
    const double error =
        planar_detail::kSlack * (std::fabs(ia.value) * jb.error + ia.error * (std::fabs(jb.value) + jb.error) +
                                 std::fabs(ib.value) * ja.error + ib.error * (std::fabs(ja.value) + ja.error) +
                                 planar_detail::kMixedError * (std::fabs(plus) + std::fabs(minus)));
    if (plus - minus > error) return 1;
    if (plus - minus < -error) return -1;
    return finer_mixed(i, j, a, b);
  }

  // The mixed side function at a point, from its sides. The error is infinite where doubles cannot be trusted.
  Side value(const LineWeights& weights, const Side& i, const Side& j) const;

  // The slope keeps references to its arguments.
  Slope slope(const LineWeights& weights, const LineOfB& i, const LineOfB& j) const {
    const auto& m = body_a_.pose.m;
    const double x = -(weights.first * i.dy + weights.second * j.dy), y = weights.first * i.dx + weights.second * j.dx;
    const double size_x = weights.first * i.size_dy + weights.second * j.size_dy;
    const double size_y = weights.first * i.size_dx + weights.second * j.size_dx;
    const double doubt = weights.exact ? planar_detail::kInfinite : compare_bound_;
    return {weights,
            i,
            j,
            m[0] * x + m[3] * y,
            m[1] * x + m[4] * y,
            doubt * (std::fabs(m[0]) * size_x + std::fabs(m[3]) * size_y),
            doubt * (std::fabs(m[1]) * size_x + std::fabs(m[4]) * size_y)};
  }

  // The mixed side function at one vertex of A less that at another.
  Side climb(const Slope& slope, std::size_t a, std::size_t b) const {
    const double vx = body_a_.shape.x(a) - body_a_.shape.x(b), vy = body_a_.shape.y(a) - body_a_.shape.y(b);
    const double size_x = std::fabs(vx), size_y = std::fabs(vy);
    const double error = slope.size_x * size_x + slope.size_y * size_y;
    const bool trusted = error > planar_detail::kSmallestError && error < planar_detail::kLargestError &&
                         planar_detail::is_usable(size_x + size_y);
    return {slope.x * vx + slope.y * vy, trusted ? error : planar_detail::kInfinite};
  }

  // Where A's line through `from` and `ahead` meets that through `other` and `behind`, as a part of `ahead` -
  // `from`; both lines lead towards the meeting point. A lower bound; infinite if no such point is sure.
  double meeting(std::size_t from, std::size_t ahead, std::size_t other, std::size_t behind) const;

  // Sign of a climb.
  int compare(const Slope& slope, std::size_t a, std::size_t b) const {
    const Side found = climb(slope, a, b);
    if (std::fabs(found.value) > found.error) return (found.value > 0) - (found.value < 0);
    return a == b ? 0 : finer_compare(slope, a, b);
  }

  Dyadic exact_side(const LineOfB& line, const PointOfA& point) const;
  const PlanarPolygon& body_a() const { return body_a_.shape; }

 private:
  const PosedPolygon& body_a_;
  const PosedPolygon& body_b_;
  double turn_;
  Precision first_;
  double side_bound_, compare_bound_;  // infinite if doubles are not to be used
  double offset_x_, offset_y_;         // of A's origin from B's, rounded
  PlanarCounters& counters_;

  static double permanent(const LineOfB& line, const PointOfA& point) {
    return line.size_dx * (point.size_y + line.size_y) + line.size_dy * (point.size_x + line.size_x);
  }

  int finer_sign(const LineOfB& line, const PointOfA& point) const;
  int finer_mixed(const LineOfB& i, const LineOfB& j, const PointOfA& a, const PointOfA& b) const;
  int finer_compare(const Slope& slope, std::size_t a, std::size_t b) const;
  void check_finite(const LineOfB& line, std::size_t point) const;
};

// The orientation of a polygon's vertices: 1 counter-clockwise, -1 clockwise, 0 if it has no area. Takes a few probes,
// O(log n) even if many vertices lie on one line.
int planar_turn(const PlanarPolygon& polygon, PlanarCounters& counters);

// Whether two polygons without area, as segments between their ends (or points), share a point; exact.
bool flat_polygons_meet(const PosedPolygon& a, const PosedPolygon& b, PlanarCounters& counters);

}  // namespace plannercheck
