// The points on one side of a plane, as a body: {x : normal · x <= offset}.
//
// It is unbounded, so it has no hull. Its Polytope is a cube that is larger than anything: code that tests only hulls
// finds every body inside the cube, which is safe. half_space_pair.hpp has the exact answers.
#pragma once

#include <array>

#include "bodies/polytope.hpp"

namespace plannercheck {

struct HalfSpace {
  Vec3 normal;  // of any length; its largest entry is between 1/2 and 1
  double offset = 0;
};

// The cofactors of M, rows first: M⁻¹ det M is the transpose.
template <class Number>
std::array<Number, 9> cofactors(const std::array<Number, 9>& m) {
  const auto minor = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    return m[a] * m[d] - m[b] * m[c];
  };
  return {minor(4, 5, 7, 8), minor(5, 3, 8, 6), minor(3, 4, 6, 7), minor(7, 8, 1, 2), minor(8, 6, 2, 0),
          minor(6, 7, 0, 1), minor(1, 2, 4, 5), minor(2, 0, 5, 3), minor(0, 1, 3, 4)};
}

// A half-space under a pose M, t is {y : normal · (y − t) <= offset}. The numbers here: normal · adj(M) = normal · M⁻¹
// det M, and offset det M. Exact for exact numbers.
template <class Number, class Vector>
struct PlaneInWorld {
  Vector normal;
  Number offset;
};

template <class Number, class Vector>
PlaneInWorld<Number, Vector> posed_plane(const HalfSpace& h, const Pose& pose) {
  std::array<Number, 9> m;
  for (std::size_t i = 0; i < 9; ++i) m[i] = Number(pose.m[i / 3 * 4 + i % 3]);
  const std::array<Number, 9> c = cofactors<Number>(m);
  const Vector n(Vec3{h.normal});
  const auto row = [&](std::size_t i) { return (c[i] * n.x + c[i + 1] * n.y) + c[i + 2] * n.z; };
  const Number determinant = (m[0] * c[0] + m[1] * c[1]) + m[2] * c[2];
  return {Vector{row(0), row(3), row(6)}, Number(h.offset) * determinant};
}

// {y : normal · y <= offset}, its normal of length 1, up to rounding.
struct WorldPlane {
  Vec3 normal;
  double offset;
};
WorldPlane world_plane(const HalfSpace& half_space, const Pose& pose);

Polytope polytope_of(const HalfSpace& half_space, double inflation_radius);

}  // namespace plannercheck
