// The affine dimension of a point set, decided exactly.
#pragma once

#include <array>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

struct AffineSpan {
  int dimension = -1;          // −1 no points, 0 coincident, 1 on a line, 2 in a plane, 3
  std::array<int, 4> index{};  // dimension + 1 affinely independent points, far apart
};

AffineSpan affine_span(const std::vector<Vec3>& points);

}  // namespace plannercheck
