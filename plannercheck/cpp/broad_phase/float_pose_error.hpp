// The error of poses that were computed in floats, without the error of rounding a pose in doubles to floats.
//
// In: the steps of a chain, as float_link_poser.hpp takes them. Out: bounds of the errors of points and directions.
// Idea: a row of the rotation errs by a vector, whose length no rotation changes; so errors of the steps add up, and do
// not multiply.
#pragma once

#include <array>
#include <cmath>

#include "broad_phase/float_sincos.hpp"
#include "math/vec.hpp"
#include "robots/kinematics.hpp"

namespace plannercheck {

// A point x of the link is off by at most turn |x| + shift, and a unit vector by `turn`; lengths in the units of the
// pose, |.| the Euclidean norm. No number of the posed origin is larger than `reach`.
struct PoseError {
  float turn = 0, shift = 0, reach = __builtin_inff();

  // The error of points no further than `reach` from the link's origin.
  float of_point(float reach) const { return turn * reach + shift; }
};

class FloatPoseError {
 public:
  FloatPoseError() = default;
  // A pose that is a placement, its numbers rounded.
  explicit FloatPoseError(const Rigid& placement) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double* const row = placement.m + 4 * k;
      row_ = larger(row_, std::sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]));
      reach_ = larger(reach_, std::fabs(row[3]));
    }
    turn_ = kU * row_;
    shift_ = kU * reach_;
  }

  // The pose times a placement. A row r: a sum of three products errs by 3u of |r| times the norm of a column, the
  // rounded column by u: together by 4u of |r| times the Frobenius norm, which is at most √3 times the largest stretch.
  // The translation t: a product, three sums and the rounded placement err by 5u of |r| times the placement's
  // translation, and the last sum by u of t.
  void place(const Rigid& placement) {
    const double stretch = largest_stretch(placement), length = translation_of(placement);
    const double row = row_ + turn_;
    shift_ += turn_ * length + kRoom * kU * (5 * row * length + reach_ + shift_);
    slid_shift_ += kRoom * kU * (slid_reach_ + slid_shift_);
    reach_ += row_ * length;
    turn_ = stretch * turn_ + kRoom * kU * 4 * kRoot3 * stretch * row;
    row_ *= stretch;
  }

  // The pose times a turn about one of its axes. Its cosine and sine err by kSinCosError each, so that a row errs by √2
  // times as much of itself; two products and a sum in each of two entries by 2 √2 u more.
  void turn() { turn_ += kRoom * std::sqrt(2) * (kSinCosError + 2 * kU) * (row_ + turn_); }

  // The pose times a shift by a distance along an axis of length l. The direction errs by 4u of |r| l; the rounded
  // distance, the product and the last sum by u more each; and that sum by u of t.
  void slide(const double* axis) {
    const double length = norm({axis[0], axis[1], axis[2]}), row = row_ + turn_;
    shift_ += kRoom * kU * (reach_ + shift_);
    slid_shift_ += turn_ * length + kRoom * kU * (7 * row * length + slid_reach_ + slid_shift_);
    slid_reach_ += row_ * length;
  }

  // `slid`: the largest distance, in absolute value, that a joint slides.
  PoseError bound(double slid) const {
    const double shift = shift_ + slid * slid_shift_;
    return {up(kRoot3 * turn_), up(kRoot3 * shift + kUnderflow), up(reach_ + slid * slid_reach_ + shift)};
  }

 private:
  static constexpr double kU = 0x1p-24;                   // half a unit in the last place of floats in [1, 2)
  static constexpr double kRoot3 = 0x1.bb67ae8584cabp+0;  // three rows that err make a vector
  static constexpr double kRoom = 1.01;                   // for products of errors, and for errors of doubles
  // Some thousand numbers lose parts below 2^-126 to underflow. In directions, this loss is far below u: kRoom covers
  // it.
  static constexpr double kUnderflow = 1e-34;

  double row_ = 0;                          // bounds the norm of the exact rotation's rows,
  double turn_ = 0;                         // and of their errors
  double reach_ = 0, shift_ = 0;            // bound entries of the translation, and their errors,
  double slid_reach_ = 0, slid_shift_ = 0;  // without slides, and for each unit of these

  static float up(double value) { return static_cast<float>(kRoom * value); }

  static double translation_of(const Rigid& placement) {
    const double* const m = placement.m;
    return norm({m[3], m[7], m[11]});
  }

  // The largest factor by which the rotation of a placement stretches vectors is at most the root of the largest row
  // sum of P^T P.
  static double largest_stretch(const Rigid& placement) {
    const double* const m = placement.m;
    double most = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < 3; ++j) sum += std::fabs(m[i] * m[j] + m[4 + i] * m[4 + j] + m[8 + i] * m[8 + j]);
      most = larger(most, sum);
    }
    return std::sqrt(most);
  }
};

}  // namespace plannercheck
