// Poses as callers give them: row-major 4x4 matrices that may hold anything.
//
// In: matrices. Out: whether they are surely rigid transforms, and verdicts of two bodies at many of them. Idea: a few
// operations here accept the surely rigid poses; the caller examines all others, and reports their faults.
#pragma once

#include <cstddef>

#include "narrow_phase/intersection.hpp"

namespace plannercheck {

inline constexpr std::size_t kGivenPose = 16;  // numbers of a matrix

// True only if a matrix is finite, ends in 0 0 0 1, is no reflection, and is off rigid by less than `tolerance`, ‖MᵀM −
// 1‖ in the Frobenius norm. May be false for rigid matrices as well.
bool is_surely_rigid(const double* matrix, double tolerance);

// The poses of one body in n pairs: `step` numbers after one another, or the same one n times if that is 0.
struct GivenPoses {
  const Polytope* body;
  const double* matrices;
  std::size_t step;
};

// Writes whether the two bodies share a point, for each of n pairs of poses. Each pose is read once, by the call that
// checks it. False, and `shared` means nothing, if some pose is not surely rigid.
bool test_given_poses(const GivenPoses& a, const GivenPoses& b, std::size_t n, double tolerance,
                      const PairOptions& options, bool* shared);

}  // namespace plannercheck
