// The double oracle: small active sets on both sides, vertices of the guest and points of the host's polar. The game
// between them decides which body is queried for one more. It ends with a checked certificate, or undecided: it never
// guesses.
#pragma once

#include <cstdint>
#include <optional>

#include "narrow_phase/active_set.hpp"
#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// The whole search from a guest's vertex; none if it has not ended after a constant number of rounds. `last`: what it
// ends with for the next poses of the pair; may be null.
std::optional<Certificate> double_oracle(const PairFrame& frame, std::int32_t guest_vertex, ActiveSet* last,
                                         PairCounters& counters);

}  // namespace plannercheck
