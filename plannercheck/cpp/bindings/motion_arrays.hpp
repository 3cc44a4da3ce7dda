// What the check of a motion finds, in space or in the plane, as arrays for Python.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bindings/array_types.hpp"
#include "motions/motion_report.hpp"

namespace plannercheck {

// (answer, proved free up to, refused at, pair) of one motion, and the proofs: pairs (k,), intervals (k, 2), directions
// (k, dimensions), gaps and chord deviations (k, 2). add_numbers(direction, row) appends a direction's numbers.
template <std::size_t dimensions, class Direction, class AddNumbers>
nanobind::tuple explained_motion(const MotionReport& report, const std::vector<IntervalProof<Direction>>& proofs,
                                 AddNumbers add_numbers) {
  std::vector<std::int32_t> pairs;
  std::vector<double> intervals, directions, gaps;
  for (const IntervalProof<Direction>& p : proofs) {
    pairs.push_back(p.pair);
    intervals.insert(intervals.end(), {p.from, p.to});
    add_numbers(p.direction, directions);
    gaps.insert(gaps.end(), {p.gap, p.chord_deviation});
  }
  const std::size_t n = proofs.size();
  return nanobind::make_tuple(static_cast<int>(report.answer), report.free_until, report.refused, report.pair,
                              output_array(pairs, {n}), output_array(intervals, {n, std::size_t{2}}),
                              output_array(directions, {n, dimensions}), output_array(gaps, {n, std::size_t{2}}));
}

}  // namespace plannercheck
