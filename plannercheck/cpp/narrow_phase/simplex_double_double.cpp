#include "narrow_phase/simplex_double_double.hpp"

#include "narrow_phase/simplex_projection.hpp"

namespace plannercheck {
namespace {

typedef SimplexProjection<DoubleDouble, DoubleDoubleVec3> FineProjection;

// The square of the distance of a projection from the origin, approximately.
double square_of(const FineProjection& found, std::size_t count) {
  const double length = dot(rounded(found.towards), rounded(found.towards)), height = found.height.high;
  const double whole = found.weight[0].high + found.weight[1].high;
  return count == 1 ? length : count == 2 ? length / (whole * whole) : count == 3 ? height * height / length : 0;
}

}  // namespace

FineFace nearest_face(const FineSimplex& simplex, unsigned needed) {
  FineFace best;
  for (unsigned set = 1; set < 1U << simplex.count; ++set) {
    if ((set & needed) != needed) continue;
    std::array<const DoubleDoubleVec3*, 4> corners{};
    std::size_t count = 0;
    for (unsigned left = set; left != 0; left &= left - 1)
      corners[count++] = &simplex.corner[static_cast<std::size_t>(__builtin_ctz(left))].difference;
    FineProjection found;
    if (!found.run(corners, count)) continue;
    const double square = square_of(found, count);
    if (square < best.square) best = {set, found.weight, found.towards, square};
  }
  return best;
}

}  // namespace plannercheck
