// Extreme vertices of small sets, by a scan: candidates in floats, then the extreme candidate in doubles.
#pragma once

#include "narrow_phase/support.hpp"

namespace plannercheck {

// The extreme vertex of a body with cells, exactly. `cell`: that of the direction x, y, z.
std::int32_t extreme_in_cell(const Levels& levels, const Cell& cell, double x, double y, double z,
                             QueryCounters& counters);

// The extreme vertex of a hierarchy's top, exactly, with what a descent needs of it.
SearchCursor cursor_at_top(const Levels& levels, Vec3 u, QueryCounters& counters);

// The extreme vertex of a top without levels below it, by rounded products; see kScanError.
std::int32_t extreme_of_top(const Levels& levels, double x, double y, double z, QueryCounters& counters);

}  // namespace plannercheck
