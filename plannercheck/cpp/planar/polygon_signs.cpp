#include "planar/polygon_signs.hpp"

#include "math/double_double.hpp"
#include "math/predicates.hpp"

namespace plannercheck {
using planar_detail::is_usable;
using planar_detail::kCrossError;
using planar_detail::kInfinite;
using planar_detail::kLargestSize;
using planar_detail::kSmallestSize;

namespace {

// The same polynomials in DoubleDouble, whose differences of coordinates are exact, take eight operations a term. Twice
// that bound holds for a difference of products of two sides.
constexpr double kSideDoubleDoubleBound = 64 * kDoubleDoubleError;

int sign_of_side(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

template <class Number>
struct Vec2 {
  Number x, y;

  friend Vec2 operator+(const Vec2& a, const Vec2& b) { return {a.x + b.x, a.y + b.y}; }
  friend Vec2 operator-(const Vec2& a, const Vec2& b) { return {a.x - b.x, a.y - b.y}; }
};

template <class Number>
Number exactly(double value) {
  if constexpr (std::is_same_v<Number, DoubleDouble>) {
    return {value, 0};
  } else {
    return Number(value);
  }
}

template <class Number>
Number exact_difference(double a, double b) {
  if constexpr (std::is_same_v<Number, DoubleDouble>) {
    return two_sum(a, -b);
  } else {
    return Number(a) - Number(b);
  }
}

template <class Number>
Number cross(const Vec2<Number>& a, const Vec2<Number>& b) {
  return a.x * b.y - a.y * b.x;
}

template <class Number>
Vec2<Number> vertex(const PlanarPolygon& polygon, std::size_t k) {
  return {exactly<Number>(polygon.x(k)), exactly<Number>(polygon.y(k))};
}

template <class Number>
Vec2<Number> between(const PlanarPolygon& polygon, std::size_t from, std::size_t to) {
  return {exact_difference<Number>(polygon.x(to), polygon.x(from)),
          exact_difference<Number>(polygon.y(to), polygon.y(from))};
}

// M v
template <class Number>
Vec2<Number> turned(const PlanarPose& pose, const Vec2<Number>& v) {
  return {exactly<Number>(pose.m[0]) * v.x + exactly<Number>(pose.m[1]) * v.y,
          exactly<Number>(pose.m[3]) * v.x + exactly<Number>(pose.m[4]) * v.y};
}

// A's vertex relative to B's origin.
template <class Number>
Vec2<Number> place(const PosedPolygon& body_a, const PosedPolygon& body_b, std::size_t k) {
  const Vec2<Number> offset{exact_difference<Number>(body_a.pose.m[2], body_b.pose.m[2]),
                            exact_difference<Number>(body_a.pose.m[5], body_b.pose.m[5])};
  return turned(body_a.pose, vertex<Number>(body_a.shape, k)) + offset;
}

template <class Number>
Number side_of(const PosedPolygon& body_a, const PosedPolygon& body_b, double turn, const LineOfB& line,
               std::size_t k) {
  const Vec2<Number> way = turned(body_b.pose, between<Number>(body_b.shape, line.from, line.to));
  const Vec2<Number> base = turned(body_b.pose, vertex<Number>(body_b.shape, line.from));
  const Number side = cross(way, place<Number>(body_a, body_b, k) - base);
  return turn > 0 ? side : -side;
}

// The side of a relative to a line, less that of b.
template <class Number>
Number side_difference(const PosedPolygon& body_a, const PosedPolygon& body_b, double turn, const LineOfB& line,
                       std::size_t a, std::size_t b) {
  const Vec2<Number> way = turned(body_b.pose, between<Number>(body_b.shape, line.from, line.to));
  const Number difference = cross(way, turned(body_a.pose, between<Number>(body_a.shape, b, a)));
  return turn > 0 ? difference : -difference;
}

Vec3 flat(const PlanarPolygon& polygon, std::size_t k) { return {polygon.x(k), polygon.y(k), 0}; }

void check_finite(const PlanarPolygon& polygon, std::size_t k) {
  if (!std::isfinite(polygon.x(k)) || !std::isfinite(polygon.y(k))) {
    throw NotFiniteError("vertex " + std::to_string(k) + " of a polygon is not finite");
  }
}

}  // namespace

int PlanarSigns::finer_sign(const LineOfB& line, const PointOfA& point) const {
  const double size = permanent(line, point);
  if (first_ != Precision::kExact && size > kSmallestSize && size < kLargestSize) {
    ++counters_.double_double;
    const DoubleDouble finer = side_of<DoubleDouble>(body_a_, body_b_, turn_, line, point.index);
    if (std::fabs(finer.high) > kSideDoubleDoubleBound * size) return sign_of_side(finer.high);
  }
  ++counters_.exact;
  return exact_side(line, point).sign();
}

Dyadic PlanarSigns::exact_side(const LineOfB& line, const PointOfA& point) const {
  check_finite(line, point.index);
  return side_of<Dyadic>(body_a_, body_b_, turn_, line, point.index);
}

int PlanarSigns::finer_mixed(const LineOfB& i, const LineOfB& j, const PointOfA& a, const PointOfA& b) const {
  const double size_ia = permanent(i, a), size_jb = permanent(j, b), size_ib = permanent(i, b),
               size_ja = permanent(j, a);
  const double smallest = smaller(smaller(size_ia, size_jb), smaller(size_ib, size_ja));
  const double largest = larger(larger(size_ia, size_jb), larger(size_ib, size_ja));
  if (first_ != Precision::kExact && smallest > kSmallestSize && largest < kLargestSize) {
    ++counters_.double_double;
    const auto finer_side = [&](const LineOfB& l, const PointOfA& p) {
      return side_of<DoubleDouble>(body_a_, body_b_, turn_, l, p.index);
    };
    const DoubleDouble fia = finer_side(i, a), fjb = finer_side(j, b), fib = finer_side(i, b), fja = finer_side(j, a);
    const DoubleDouble finer = fia * fjb - fib * fja;
    // Each side errs by at most kSideDoubleDoubleBound of its permanent; twice that covers products and difference.
    const double bound =
        2 * kSideDoubleDoubleBound *
        (std::fabs(fia.high) * size_jb + size_ia * (std::fabs(fjb.high) + kSideDoubleDoubleBound * size_jb) +
         std::fabs(fib.high) * size_ja + size_ib * (std::fabs(fja.high) + kSideDoubleDoubleBound * size_ja));
    if (std::fabs(finer.high) > bound) return sign_of_side(finer.high);
  }
  ++counters_.exact;
  return (exact_side(i, a) * exact_side(j, b) - exact_side(i, b) * exact_side(j, a)).sign();
}

Side PlanarSigns::value(const LineWeights& weights, const Side& i, const Side& j) const {
  const double first = weights.first * i.value, second = weights.second * j.value;
  if (weights.exact) return {0, kInfinite};
  const double size = std::fabs(first) + std::fabs(second);
  return {first + second, planar_detail::kSlack *
                              (weights.first * i.error + weights.second * j.error + planar_detail::kMixedError * size)};
}

double PlanarSigns::meeting(std::size_t from, std::size_t ahead, std::size_t other, std::size_t behind) const {
  const PlanarPolygon& p = body_a_.shape;
  const double ax = p.x(ahead) - p.x(from), ay = p.y(ahead) - p.y(from);
  const double bx = p.x(behind) - p.x(other), by = p.y(behind) - p.y(other);
  const double cx = p.x(other) - p.x(from), cy = p.y(other) - p.y(from);
  const double sine = ax * by - ay * bx, reach = cx * by - cy * bx, back = cx * ay - cy * ax;
  const double sine_error = kCrossError * (std::fabs(ax * by) + std::fabs(ay * bx));
  const double reach_error = kCrossError * (std::fabs(cx * by) + std::fabs(cy * bx));
  const double back_error = kCrossError * (std::fabs(cx * ay) + std::fabs(cy * ax));
  const bool usable = first_ == Precision::kDoubles && sine_error > kSmallestSize && reach_error > kSmallestSize &&
                      back_error > kSmallestSize && std::fabs(reach) < kLargestSize && std::fabs(back) < kLargestSize;
  const double sign = sine > 0 ? 1 : -1;
  // The meeting point lies ahead on both lines: reach / sine > 0, back / sine > 0.
  if (!usable || std::fabs(sine) <= sine_error || sign * reach <= reach_error || sign * back <= back_error)
    return kInfinite;
  return planar_detail::kSlack * (std::fabs(reach) + reach_error) / (std::fabs(sine) - sine_error);
}

int PlanarSigns::finer_compare(const Slope& slope, std::size_t a, std::size_t b) const {
  const auto& [weights, i, j, x, y, size_x, size_y] = slope;
  const auto& m = body_a_.pose.m;
  const double vx = std::fabs(body_a_.shape.x(a) - body_a_.shape.x(b)),
               vy = std::fabs(body_a_.shape.y(a) - body_a_.shape.y(b));
  const double size_wx = std::fabs(m[0]) * vx + std::fabs(m[1]) * vy,
               size_wy = std::fabs(m[3]) * vx + std::fabs(m[4]) * vy;
  const double size = weights.first * (i.size_dx * size_wy + i.size_dy * size_wx) +
                      weights.second * (j.size_dx * size_wy + j.size_dy * size_wx);
  if (first_ != Precision::kExact && !weights.exact && size > kSmallestSize && size < kLargestSize &&
      is_usable(vx + vy)) {
    ++counters_.double_double;
    const DoubleDouble finer =
        DoubleDouble{weights.first, 0} * side_difference<DoubleDouble>(body_a_, body_b_, turn_, i, a, b) +
        DoubleDouble{weights.second, 0} * side_difference<DoubleDouble>(body_a_, body_b_, turn_, j, a, b);
    if (std::fabs(finer.high) > kSideDoubleDoubleBound * size) return sign_of_side(finer.high);
  }
  ++counters_.exact;
  check_finite(i, a);
  check_finite(j, b);
  const Dyadic first = weights.exact ? (*weights.exact)[0] : Dyadic(weights.first);
  const Dyadic second = weights.exact ? (*weights.exact)[1] : Dyadic(weights.second);
  Dyadic sum = first * side_difference<Dyadic>(body_a_, body_b_, turn_, i, a, b);
  if (second.sign() != 0) sum = sum + second * side_difference<Dyadic>(body_a_, body_b_, turn_, j, a, b);
  return sum.sign();
}

// Numbers that are not finite fail every filter, so they are checked only before exact arithmetic.
void PlanarSigns::check_finite(const LineOfB& line, std::size_t point) const {
  plannercheck::check_finite(body_b_.shape, line.from);
  plannercheck::check_finite(body_b_.shape, line.to);
  plannercheck::check_finite(body_a_.shape, point);
}

// Three vertices lie on a line. In a convex polygon the arc between the outer two that holds the middle one lies on
// that line, too, so the rest of the boundary is the other arc. Its middle vertex is off the line, or replaces an end.
int planar_turn(const PlanarPolygon& polygon, PlanarCounters& counters) {
  const std::size_t n = polygon.count;
  if (n < 3) return 0;
  const std::array<std::size_t, 3> probes{0, n / 3, 2 * n / 3};
  counters.vertices += 3;
  const double ax = polygon.x(probes[1]) - polygon.x(probes[0]), ay = polygon.y(probes[1]) - polygon.y(probes[0]);
  const double bx = polygon.x(probes[2]) - polygon.x(probes[0]), by = polygon.y(probes[2]) - polygon.y(probes[0]);
  const double value = ax * by - ay * bx, size = std::fabs(ax * by) + std::fabs(ay * bx);
  if (size > kSmallestSize && size < kLargestSize && std::fabs(value) > kCrossError * size) {
    return sign_of_side(value);
  }
  for (const std::size_t k : probes) check_finite(polygon, k);
  const int found = turn(flat(polygon, probes[0]), flat(polygon, probes[1]), flat(polygon, probes[2]), 2);
  if (found != 0) return found;
  const bool along_x = polygon.x(probes[0]) != polygon.x(probes[1]) || polygon.x(probes[0]) != polygon.x(probes[2]);
  const auto position = [&](std::size_t k) { return along_x ? polygon.x(k) : polygon.y(k); };
  // The probe between the other two; its neighbours among the probes are the ends of the other arc.
  std::size_t middle = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double here = position(probes[k]), one = position(probes[(k + 1) % 3]), two = position(probes[(k + 2) % 3]);
    if ((one <= here && here <= two) || (two <= here && here <= one)) middle = k;
  }
  std::size_t start = probes[(middle + 1) % 3], end = probes[(middle + 2) % 3];
  while (true) {
    const std::size_t length = (end + n - start) % n;
    if (length < 2) return 0;
    const std::size_t k = (start + length / 2) % n;
    ++counters.vertices;
    check_finite(polygon, k);
    const int sign = turn(flat(polygon, start), flat(polygon, k), flat(polygon, end), 2);
    if (sign != 0) return sign;
    const bool beyond_start = (position(k) < position(start)) == (position(start) < position(end));
    (beyond_start ? start : end) = k;
  }
}

namespace {

// The outermost two vertices of a polygon on a line, as dyadic numbers of the world.
std::array<Vec2<Dyadic>, 2> ends_of(const PosedPolygon& body, PlanarCounters& counters) {
  const PlanarPolygon& shape = body.shape;
  const auto before = [&](std::size_t a, std::size_t b) {
    return shape.x(a) < shape.x(b) || (shape.x(a) == shape.x(b) && shape.y(a) < shape.y(b));
  };
  std::size_t first = 0, last = 0;
  for (std::size_t k = 0; k < shape.count; ++k) {
    ++counters.vertices;
    check_finite(shape, k);
    if (before(k, first)) first = k;
    if (before(last, k)) last = k;
  }
  const Vec2<Dyadic> offset{Dyadic(body.pose.m[2]), Dyadic(body.pose.m[5])};
  return {turned(body.pose, vertex<Dyadic>(shape, first)) + offset,
          turned(body.pose, vertex<Dyadic>(shape, last)) + offset};
}

bool ranges_meet(const Dyadic& a0, const Dyadic& a1, const Dyadic& b0, const Dyadic& b1) {
  const auto [low_a, high_a] = (a1 - a0).sign() < 0 ? std::pair{a1, a0} : std::pair{a0, a1};
  const auto [low_b, high_b] = (b1 - b0).sign() < 0 ? std::pair{b1, b0} : std::pair{b0, b1};
  return (high_b - low_a).sign() >= 0 && (high_a - low_b).sign() >= 0;
}

}  // namespace

bool flat_polygons_meet(const PosedPolygon& a, const PosedPolygon& b, PlanarCounters& counters) {
  const auto [a0, a1] = ends_of(a, counters);
  const auto [b0, b1] = ends_of(b, counters);
  const auto orientation = [](const Vec2<Dyadic>& p, const Vec2<Dyadic>& q, const Vec2<Dyadic>& r) {
    return cross(q - p, r - p).sign();
  };
  const int a0_side = orientation(b0, b1, a0), a1_side = orientation(b0, b1, a1);
  const int b0_side = orientation(a0, a1, b0), b1_side = orientation(a0, a1, b1);
  counters.exact += 4;
  if (a0_side * a1_side > 0 || b0_side * b1_side > 0) return false;
  if (a0_side != 0 || a1_side != 0 || b0_side != 0 || b1_side != 0) return true;
  return ranges_meet(a0.x, a1.x, b0.x, b1.x) && ranges_meet(a0.y, a1.y, b0.y, b1.y);
}

}  // namespace plannercheck
