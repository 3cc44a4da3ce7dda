// Facet planes of small bodies: of the pairs that are apart, however near, such a plane separates nine in ten.
//
// All corners of one body are tested against all facets of the other, in lanes; the best plane is then proved.
#pragma once

#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

inline constexpr std::size_t kFewCorners = 8;  // so at most 12 facets: with more, support queries are cheaper

inline bool has_few_corners(const Polytope& body) {
  return body.inner.points.size() <= kFewCorners && body.has_polar();
}

// For two bodies of few corners: tries the host's facets, then the guest's; undecided if none separates.
Certificate facet_plane(const PairFrame& frame, const Pose& guest, const CentreAxis& axis, PairCounters& counters);

}  // namespace plannercheck
