// Clearances of single points from a set of parts by its grid, for tests that compare the grid with the parts.
#pragma once

#include <vector>

#include "bodies/part_set.hpp"

namespace plannercheck {

// Two numbers for each of n points (n, 3): looked up alone, and in lanes. None if the grid's steps would be too long.
std::vector<double> clearances_at(const PartSet& parts, const Pose& pose, double reach, const double* points,
                                  std::size_t n);

}  // namespace plannercheck
