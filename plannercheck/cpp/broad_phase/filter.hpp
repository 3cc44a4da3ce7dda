// A filter's result for a pair of bodies: the states of a block in which they are apart or overlap; the others stay
// open.
//
// Every filter has a function that takes a pair and its posed bounds, and returns such masks. Each filter is proved
// with its rounding, so that none changes a verdict.
#pragma once

namespace plannercheck {

struct Masks {
  unsigned apart = 0, overlap = 0;  // states in which both surely share no point, or surely share one
};

}  // namespace plannercheck
