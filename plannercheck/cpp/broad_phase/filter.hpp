// What a filter says of a pair of bodies in the states of a block, a bit each; in other states it says nothing.
//
// Every filter has a function that takes a pair and what is posed of it, and returns such masks. Each is proved with
// its rounding, so that no filter changes a verdict.
#pragma once

namespace plannercheck {

struct Masks {
  unsigned apart = 0, overlap = 0;  // states in which both surely share no point, or surely share one
};

}  // namespace plannercheck
