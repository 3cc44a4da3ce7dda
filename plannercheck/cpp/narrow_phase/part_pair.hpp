// Whether two bodies share a point of which at least one is a set of parts, exactly; and how far apart they are.
//
// In: two posed bodies. Out: a part that shares a point with the other body, or a lower bound of the distance. The
// parts whose boxes come near the other body's are tested as bodies of few vertices by the test of pairs, which is
// exact. Balls and boxes that meet a ball inside the other body need no test.
#pragma once

#include <cstdint>

#include "narrow_phase/distance.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// Places of parts in their sets that share a point; −1 for a body that is no set, and where nothing is shared.
struct PartContact {
  bool shared = false;
  std::int32_t a = -1, b = -1;
};

// `guess`: where the pair met last; it only saves time. `trees`: off, each part is tested by itself, as a body of few
// vertices; nothing but time depends on it.
PartContact parts_contact(const PosedPolytope& a, const PosedPolytope& b, const PartContact& guess,
                          PairCounters& counters, bool trees = true);

// The distance of two bodies that share no point. `limit`, `visit`: as for pair_distance. `least`: a lower bound that
// is known. `trees`: as for parts_contact.
PairDistance parts_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit, double least,
                            PairCounters& counters, bool trees = true, const PartVisitor* visit = nullptr);

}  // namespace plannercheck
