#include "math/predicates.hpp"

#include "math/double_double.hpp"

namespace plannercheck {
using predicates_detail::absolute_dot;
using predicates_detail::trusted;

namespace {

int sign_of(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

// Bounds of the error of a sign's polynomial, as multiples of the sum of its terms' absolute values (the permanent).
// The rounding of the last sum changes no sign and is not counted.
//
// Determinants: three differences, product, difference, product and sum, 7u; from another corner one less.
constexpr double kDeterminantError = 8 * kRoundoff;
// Degree 4: two differences, product and difference, product and difference, product and sum, 8u.
constexpr double kWedgeError = 16 * kRoundoff;
// Entries of a cross product: two differences and a product, 3u.
constexpr double kTurnError = 6 * kRoundoff;
// The same in DoubleDouble, whose differences are exact: at most seven operations.
constexpr double kDoubleDoubleBound = 32 * kDoubleDoubleError;

Vec3 absolute_cross(Vec3 a, Vec3 b) {
  return {std::fabs(a.y * b.z) + std::fabs(a.z * b.y), std::fabs(a.z * b.x) + std::fabs(a.x * b.z),
          std::fabs(a.x * b.y) + std::fabs(a.y * b.x)};
}

}  // namespace

int orientation(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  const Vec3 ab = b - a, ac = c - a, ad = d - a;
  const double determinant = dot(cross(ab, ac), ad);
  const double permanent = absolute_dot(absolute_cross(ab, ac), ad);
  const double largest = larger(norm_max(ab), larger(norm_max(ac), norm_max(ad)));
  const bool in_range = trusted(permanent, largest);
  if (in_range && std::fabs(determinant) > kDeterminantError * permanent) return sign_of(determinant);
  // Differences of doubles are 0 only when the doubles are equal: planes parallel to the axes end here.
  const bool axis_aligned = (ab.x == 0 && ac.x == 0 && ad.x == 0) || (ab.y == 0 && ac.y == 0 && ad.y == 0) ||
                            (ab.z == 0 && ac.z == 0 && ad.z == 0);
  if (axis_aligned) return 0;
  if (in_range) {
    const DoubleDouble finer = dot(cross(difference(b, a), difference(c, a)), difference(d, a));
    if (std::fabs(finer.high) > kDoubleDoubleBound * permanent) return sign_of(finer.high);
  }
  const DyadicVec3 origin(a);
  return dot(cross(DyadicVec3(b) - origin, DyadicVec3(c) - origin), DyadicVec3(d) - origin).sign();
}

int compare_along_finer(Vec3 u, Vec3 a, Vec3 b) {
  const Vec3 e = a - b;
  if ((u.x == 0 || e.x == 0) && (u.y == 0 || e.y == 0) && (u.z == 0 || e.z == 0)) return 0;
  const double size = absolute_dot(u, e);
  if (trusted(size, larger(norm_max(u), norm_max(e)))) {
    const DoubleDouble finer = dot(widen(u), difference(a, b));
    if (std::fabs(finer.high) > kDoubleDoubleBound * size) return sign_of(finer.high);
  }
  return dot(DyadicVec3(u), DyadicVec3(a) - DyadicVec3(b)).sign();
}

int wedge_side(Vec3 z, Vec3 v, Vec3 a, Vec3 b, Vec3 u) {
  const Vec3 va = a - v, vb = b - v;
  const double value = dot(cross(z, cross(va, vb)), u);
  const Vec3 absolute_z{std::fabs(z.x), std::fabs(z.y), std::fabs(z.z)};
  const double size = absolute_dot(absolute_cross(absolute_z, absolute_cross(va, vb)), u);
  const double largest = larger(larger(norm_max(z), norm_max(u)), larger(norm_max(va), norm_max(vb)));
  const bool in_range = trusted(size, largest) && largest < 1e40;
  if (in_range && std::fabs(value) > kWedgeError * size) return sign_of(value);
  if (in_range) {
    const DoubleDouble finer = dot(cross(widen(z), cross(difference(a, v), difference(b, v))), widen(u));
    if (std::fabs(finer.high) > kDoubleDoubleBound * size) return sign_of(finer.high);
  }
  const DyadicVec3 corner(v);
  return dot(cross(DyadicVec3(z), cross(DyadicVec3(a) - corner, DyadicVec3(b) - corner)), DyadicVec3(u)).sign();
}

int cone_side(Vec3 u, Vec3 o, Vec3 a, Vec3 b) {
  const Vec3 oa = a - o, ob = b - o;
  const double value = dot(cross(oa, ob), u), size = absolute_dot(absolute_cross(oa, ob), u);
  const double largest = larger(norm_max(u), larger(norm_max(oa), norm_max(ob)));
  if (trusted(size, largest) && std::fabs(value) > kDeterminantError * size) return sign_of(value);
  const DyadicVec3 origin(o);
  return dot(cross(DyadicVec3(a) - origin, DyadicVec3(b) - origin), DyadicVec3(u)).sign();
}

int turn(Vec3 a, Vec3 b, Vec3 c, int axis) {
  const double value = cross(b - a, c - a)[axis], size = absolute_cross(b - a, c - a)[axis];
  if (trusted(size, larger(norm_max(b - a), norm_max(c - a))) && std::fabs(value) > kTurnError * size) {
    return sign_of(value);
  }
  const DyadicVec3 origin(a);
  const DyadicVec3 exact = cross(DyadicVec3(b) - origin, DyadicVec3(c) - origin);
  return (axis == 0 ? exact.x : axis == 1 ? exact.y : exact.z).sign();
}

bool collinear(Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 n = cross(b - a, c - a), size = absolute_cross(b - a, c - a);
  for (int axis = 0; axis < 3; ++axis) {
    if (size[axis] > predicates_detail::kSmallestTrusted && size[axis] < predicates_detail::kLargestTrusted &&
        std::fabs(n[axis]) > kTurnError * size[axis])
      return false;
  }
  const DyadicVec3 origin(a);
  const DyadicVec3 exact = cross(DyadicVec3(b) - origin, DyadicVec3(c) - origin);
  return exact.x.sign() == 0 && exact.y.sign() == 0 && exact.z.sign() == 0;
}

}  // namespace plannercheck
