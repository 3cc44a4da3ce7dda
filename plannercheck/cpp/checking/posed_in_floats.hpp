// The poses in floats of broad_phase/float_link_poser.hpp, row by row, for tests of their error bounds. This header is
// free of lanes.
#pragma once

#include <cstddef>
#include <vector>

#include "robots/kinematics.hpp"

namespace plannercheck {

// By row and link: a row-major 3x4 matrix, and how far a unit vector and the origin may be off. NaN for links that are
// not needed and for rows that are posed in doubles.
struct PosedInFloats {
  std::vector<float> poses, errors;
};

PosedInFloats posed_in_floats(const Kinematics& kinematics, const double* q, std::size_t n,
                              const unsigned char* needed);

}  // namespace plannercheck
