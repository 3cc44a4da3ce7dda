#include "narrow_phase/winding_number.hpp"

#include <array>
#include <cmath>
#include <optional>

#include "bodies/lane_boxes.hpp"
#include "math/dyadic.hpp"
#include "math/simd.hpp"

namespace plannercheck {
namespace {

// The errors behind signs. The point errs by e in each coordinate, differences are at most L in size and err by e + uL.
// In the plane: four such errors, each times L, and 4u L² of rounding. In space only one column errs by e, the others
// by uL: each of six products errs by L² (e + 3uL), and rounding adds 6 · 6u L³.
constexpr double kTurnOfError = 6, kTurnOfRounding = 12 * kRoundoff;
constexpr double kHeightOfError = 8, kHeightOfRounding = 64 * kRoundoff;

// Between these, products of three neither overflow nor underflow.
constexpr double kLeastWay = 1e-90, kLargestWay = 1e90;

// Coordinates in floats of the tree's units.
constexpr float kFloatWay = 0x1p-21F;

int sign_within(double value, double bound) { return value > bound ? 1 : value < -bound ? -1 : 0; }
int sign_of_difference(double a, double b) { return a > b ? 1 : a < b ? -1 : 0; }

// A point in a solid's frame: rounded, and exactly as a vector divided by a positive number.
class FramedPoint {
 public:
  FramedPoint(const PosedSolid& around, const Pose& from, Vec3 point) : around_(around), from_(from), point_(point) {
    const InversePose inverse(around.pose);
    const Vec3 in_world = from.apply(point);
    double magnitude = 0;
    for (std::size_t row = 0; row < 12; row += 4) {
      magnitude = larger(magnitude, std::fabs(from.m[row] * point.x) + std::fabs(from.m[row + 1] * point.y) +
                                        std::fabs(from.m[row + 2] * point.z) + std::fabs(from.m[row + 3]));
    }
    rounded_ = inverse.apply(in_world);
    error_ = inverse.error(magnitude);
  }

  Vec3 rounded() const { return rounded_; }
  double error() const { return error_; }

  // The sign of the turn from a to b around the point, seen from above.
  int turn(Vec3 a, Vec3 b) {
    const double ax = a.x - rounded_.x, ay = a.y - rounded_.y, bx = b.x - rounded_.x, by = b.y - rounded_.y;
    const double size = larger(larger(std::fabs(ax), std::fabs(ay)), larger(std::fabs(bx), std::fabs(by)));
    if (is_trusted(size)) {
      const double bound = size * (kTurnOfError * error_ + kTurnOfRounding * size);
      if (const int sign = sign_within(ax * by - ay * bx, bound); sign != 0) return sign;
    }
    const DyadicVec3 u = to_exactly(a), v = to_exactly(b);
    return (u.x * v.y - u.y * v.x).sign();
  }

  // Whether the point is below the plane of a triangle that is counter-clockwise seen from above; it is not in it.
  bool is_below(Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 to = rounded_ - a, ab = b - a, ac = c - a;
    const double size = larger(norm_max(to), larger(norm_max(ab), norm_max(ac)));
    if (is_trusted(size)) {
      const double bound = size * size * (kHeightOfError * error_ + kHeightOfRounding * size);
      if (const int sign = sign_within(dot(cross(ab, ac), to), bound); sign != 0) return sign < 0;
    }
    const DyadicVec3 corner(a);
    return dot(cross(DyadicVec3(b) - corner, DyadicVec3(c) - corner), to_exactly(a)).sign() > 0;
  }

 private:
  const PosedSolid& around_;
  const Pose& from_;
  Vec3 point_, rounded_;
  double error_;
  std::optional<DyadicVec3> exact_;  // times the determinant
  Dyadic determinant_;

  bool is_trusted(double size) const { return size > kLeastWay && size < kLargestWay && error_ < size; }

  // The way from the point to v, times the determinant of the frame's map, which is positive.
  DyadicVec3 to_exactly(Vec3 v) {
    if (!exact_) make_exact();
    return determinant_ * DyadicVec3(v) - *exact_;
  }

  void make_exact() {
    const Pose& pose = around_.pose;
    const DyadicVec3 x(pose.column(0)), y(pose.column(1)), z(pose.column(2)), yz = cross(y, z);
    const DyadicVec3 to = apply_exactly(from_, point_) - DyadicVec3(pose.translation());
    determinant_ = dot(x, yz);
    exact_ = DyadicVec3(dot(yz, to), dot(cross(z, x), to), dot(cross(x, y), to));
  }
};

// 1 or −1 for a triangle above or below the thought start of the ray that is counter-clockwise seen from above, or
// clockwise; 0 if the ray's line passes it by.
int side_of_line(FramedPoint& point, const std::array<Vec3, 3>& t) {
  int side = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 a = t[k], b = t[k == 2 ? 0 : k + 1];
    int sign = point.turn(a, b);
    if (sign == 0) sign = sign_of_difference(b.x, a.x);  // the coefficient of ε
    if (sign == 0) sign = sign_of_difference(a.y, b.y);  // of ε²
    if (sign == 0 || sign == -side) return 0;
    side = sign;
  }
  return side;
}

}  // namespace

int winding_number(const PosedSolid& around, const Pose& from, Vec3 in_from) {
  const TriangleTree& tree = around.solid->tree;
  FramedPoint point(around, from, in_from);
  const Vec3 place = tree.units * (point.rounded() - tree.middle);
  const std::array<float, 3> start{static_cast<float>(place.x), static_cast<float>(place.y),
                                   static_cast<float>(place.z)};
  const auto room = static_cast<float>(
      (1 + norm_max(place)) * static_cast<double>(kFloatWay) +
      2 * tree.units * (point.error() + kRoundoff * (norm_max(tree.middle) + norm_max(point.rounded()))));
  int number = 0;
  any_triangle(
      tree, [&](const TriangleNode& node) { return children_on_ray(node, start, room); },
      [&](std::int32_t triangle) {
        const std::array<Vec3, 3> corners = tree.corners(triangle);
        const int side = side_of_line(point, corners);
        const bool is_up = side > 0;
        if (side != 0 && point.is_below(corners[0], corners[is_up ? 1 : 2], corners[is_up ? 2 : 1])) number += side;
        return false;
      });
  return number;
}

}  // namespace plannercheck
