// Planes of small bodies' facets: of two bodies that are apart, however near, nine pairs in ten are separated by one.
//
// All corners of one body are held against all facets of the other, in lanes; what looks best is then proved.
#pragma once

#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

inline constexpr std::size_t kFewCorners = 8;  // so at most 12 facets: beyond, asking for extreme vertices costs less

inline bool has_few_corners(const Body& body) { return body.inner.points.size() <= kFewCorners && body.has_polar(); }

// Of two bodies of few corners: by a facet of the host or of the guest; undecided if none separates.
Certificate facet_plane(const PairFrame& frame, const CentreAxis& axis, PairCounters& counters);

}  // namespace plannercheck
