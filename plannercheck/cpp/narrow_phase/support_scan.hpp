// Extreme vertices of bodies, or tops of hierarchies, of so few vertices that scanning beats walking: in floats for
// candidates, in doubles among these.
#pragma once

#include "narrow_phase/support.hpp"

namespace plannercheck {

// The vertex of a body with cells, exactly. `cell`: u's.
std::int32_t extreme_in_cell(const Levels& levels, const Cell& cell, Vec3 u, QueryCounters& counters);

// Of a hierarchy's top, exactly, with what a descent needs of it.
Stand stand_at_top(const Levels& levels, Vec3 u, QueryCounters& counters);

// Of a top below which nothing follows: by rounded products, see kScanError.
std::int32_t extreme_of_top(const Levels& levels, Vec3 u, QueryCounters& counters);

}  // namespace plannercheck
