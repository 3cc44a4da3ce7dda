// The face of a simplex nearest to the origin, in double-double, for each round of gjk_double_double.cpp.
//
// In: one to four corners, differences of vertices. Out: some of the corners, with weights that mix the point of their
// hull nearest to the origin, up to rounding. The result is only a guide: the caller proves its answers from any
// corners and weights.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "math/double_double.hpp"

namespace plannercheck {

struct FineCorner {
  std::int32_t body_a, body_b;
  DoubleDoubleVec3 difference;  // A vertex − B vertex in the world, in units
};

// The hull of some corners with the weights of its point nearest to the origin.
struct FineFace {
  unsigned set = 0;
  std::array<DoubleDouble, 4> weight{};                     // in the order of the corners of the set
  DoubleDoubleVec3 towards;                                 // along the nearest point, of any length
  double square = std::numeric_limits<double>::infinity();  // of the distance, approximately
};

struct FineSimplex {
  int count = 0;
  std::array<FineCorner, 4> corner;
  std::array<DoubleDouble, 4> weight{};
};

// The nearest of the faces whose sets include `needed`.
FineFace nearest_face(const FineSimplex& simplex, unsigned needed);

}  // namespace plannercheck
