// The heights right under a body, before any tree: whether the body is above all of them, or its lowest vertex is below
// one.
//
// In: a posed hull or solid, and a posed field of heights. Out: whether they surely share no point, surely do, or
// neither is known. A body has few heights below it, mostly in adjacent memory, while a descent in the tree waits for
// each node before the next.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

Answer look_at_heights(const PosedPolytope& body, const PosedPolytope& field);

}  // namespace plannercheck
