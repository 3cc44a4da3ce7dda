#include "bodies/affine_dimension.hpp"

#include "math/predicates.hpp"

namespace plannercheck {
namespace {

template <class Value>
int furthest(const std::vector<Vec3>& points, Value value) {
  int best = 0;
  for (int i = 1; i < static_cast<int>(points.size()); ++i) {
    if (value(points[at(i)]) > value(points[at(best)])) best = i;
  }
  return best;
}

// The first index for which the exact test holds, the guess tried first; −1 if there is none.
template <class Test>
int first_that(const std::vector<Vec3>& points, int guess, Test test) {
  if (test(points[at(guess)])) return guess;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    if (test(points[at(i)])) return i;
  }
  return -1;
}

}  // namespace

AffineSpan affine_span(const std::vector<Vec3>& points) {
  AffineSpan span;
  const auto extend = [&](int index) {
    if (index >= 0) span.index[static_cast<std::size_t>(++span.dimension)] = index;
    return index >= 0;
  };
  if (points.empty() || !extend(furthest(points, [](Vec3 p) { return -p.x; }))) return span;
  const Vec3 a = points[at(span.index[0])];
  const int far = furthest(points, [&](Vec3 p) { return norm(p - a); });
  if (!extend(first_that(points, far, [&](Vec3 p) { return !(p == a); }))) return span;
  const Vec3 b = points[at(span.index[1])];
  const int beside = furthest(points, [&](Vec3 p) { return norm(cross(b - a, p - a)); });
  if (!extend(first_that(points, beside, [&](Vec3 p) { return !collinear(a, b, p); }))) return span;
  const Vec3 c = points[at(span.index[2])], normal = cross(b - a, c - a);
  const int above = furthest(points, [&](Vec3 p) { return std::fabs(dot(normal, p - a)); });
  extend(first_that(points, above, [&](Vec3 p) { return orientation(a, b, c, p) != 0; }));
  return span;
}

}  // namespace plannercheck
