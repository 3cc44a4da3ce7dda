#include "narrow_phase/posed_solid.hpp"

namespace plannercheck {
namespace {

// The error of M⁻¹ (p − t), as a part of y, the magnitude of p and t together: the difference errs by u|y|. Entries of
// the adjugate err by 4u, its products with y and their sums by 3u of at most √3 |y|: 18u|y|. The determinant is 1 up
// to 6e-6 and errs by 13u, its reciprocal and the product with that by one more each: 26u|y|. What p errs by, 5u (a
// product, three sums, and rounding of the magnitude), is turned: at most √3 times that, 9u.
constexpr double kInverseError = 64 * kRoundoff;

// The error of a relative pose, as a part of |p|_1 + |t_a − t_b|_1: its columns are M⁻¹ times vectors, each coordinate
// of which errs by 26u of the vector's length, as above, and its shift by u more for the difference; products and sums
// add 4u.
constexpr double kRelativeError = 48 * kRoundoff;

}  // namespace

InversePose::InversePose(const Pose& pose) : translation_(pose.translation()) {
  const Vec3 x = pose.column(0), y = pose.column(1), z = pose.column(2);
  const Vec3 across = cross(y, z);
  const double inverse = 1 / dot(x, across);
  rows_ = {inverse * across, inverse * cross(z, x), inverse * cross(x, y)};
}

double InversePose::error(double magnitude) const {
  return kInverseError * (magnitude + norm_max(translation_)) + kDenormalError;
}

RelativePose::RelativePose(const Pose& from, const Pose& to) {
  const InversePose inverse(to);
  const Vec3 way = from.translation() - to.translation();
  for (std::size_t j = 0; j < 4; ++j) {
    const Vec3 column = inverse.rotate(j == 3 ? way : from.column(j));
    pose_.m[j] = column.x, pose_.m[j + 4] = column.y, pose_.m[j + 8] = column.z;
  }
  distance_ = norm_1(way);
}

double RelativePose::error(double reach) const { return kRelativeError * (reach + distance_) + kDenormalError; }

}  // namespace plannercheck
