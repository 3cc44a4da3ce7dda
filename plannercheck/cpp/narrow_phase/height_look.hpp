// What the heights right under a body tell, before any tree: the body is over all of them, or its lowest vertex is
// under some.
//
// In: a posed hull or solid, and a posed field of heights. Out: whether they surely share no point, surely do, or
// neither is known. Of the few heights there are under a body, most are in rows that memory gives at once; a walk down
// the tree waits for each node before the next.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

Answer look_at_heights(const PosedPolytope& body, const PosedPolytope& field);

}  // namespace plannercheck
