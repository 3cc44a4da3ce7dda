// Boxes along axes of their own, in floats: as thin as the patch of a surface that they hold.
//
// In: corners of triangles, in units in which they reach from −1 to 1. Out: a box around them. Its axes are the frame's
// axes or the principal axes of the triangles, whichever give the smaller box. Idea: a small patch of a smooth surface
// is nearly flat; its extent along the normal is about the square of its size, so few pairs of patches of two surfaces
// near contact have boxes that meet (Gottschalk, Lin and Manocha, OBBTree, 1996). Two axes are kept in 16 bits an
// entry; the third is their cross product. Axes are what these numbers say, and half extents count along them: x =
// centre + Σ t_j axis_j with |t_j| ≤ half_j, for each x that is held. So rounding the axes loses no point; code that
// projects the box has to allow for axes that are not quite orthonormal.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "math/vec.hpp"

namespace plannercheck {

struct OrientedBox {
  std::array<float, 3> centre;
  std::array<std::array<float, 3>, 3> axis;
  std::array<float, 3> half;

  float extent() const { return half[0] + half[1] + half[2]; }
};

// Along the frame's axes.
struct AlignedBox {
  std::array<float, 3> centre, half;
};

// For sums of half extents times axes, in floats, which round six times at most.
inline constexpr float kAroundRoundedUp = 1 + 0x1p-20F;

// Holds the box.
AlignedBox around(const OrientedBox& box);

// Entries of the first two axes, in parts of kShortUnit.
using ShortAxes = std::array<std::array<std::int16_t, 3>, 2>;
inline constexpr float kShortUnit = 1.0F / 32767;

// Squares of axes' lengths differ from 1, and their products from 0, by at most this: an entry errs by half a unit, so
// that an axis errs by 2.65e-5, its square and the product of the first two by 5.3e-5, and the square of the third,
// which is the product of their squares less that of their product, by 1.07e-4.
inline constexpr float kAxisError = 0x1p-13F;

// For numbers or lanes of numbers. Each step is rounded, so that both give the same bits.
template <class Real>
std::array<Real, 3> third_axis(const std::array<Real, 3>& a, const std::array<Real, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline std::array<std::array<float, 3>, 3> unpacked(const ShortAxes& axes) {
  std::array<std::array<float, 3>, 3> out;
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < 3; ++i) out[j][i] = static_cast<float>(axes[j][i]) * kShortUnit;
  }
  out[2] = third_axis(out[0], out[1]);
  return out;
}

// Integrals over triangles: of 1, x and x xᵀ, so as xx, yy, zz, yz, zx, xy.
struct SurfaceMoments {
  double area = 0;
  Vec3 first;
  std::array<double, 6> second{};

  void add(const SurfaceMoments& other);
};

SurfaceMoments moments_of(Vec3 a, Vec3 b, Vec3 c);

// Points by coordinate, side by side.
struct PointColumns {
  const double *x, *y, *z;
  std::size_t count;
};

struct FittedBox {
  ShortAxes axes;
  OrientedBox box;
};

// Around points, along the frame's axes or the principal ones of the moments.
FittedBox fitted_box(const PointColumns& points, const SurfaceMoments& moments);

// Around points, along the frame's axes.
FittedBox box_along_frame(const PointColumns& points);

// Around three points, along the frame's axes or the triangle's longest edge and normal.
FittedBox fitted_box_of_triangle(const PointColumns& points);

}  // namespace plannercheck
