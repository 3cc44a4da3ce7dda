// The double oracle: small active sets on both sides, vertices of the guest and points of the host's polar. The game
// between them decides which body is queried for one more. It ends with a checked certificate, or undecided: it never
// guesses.
#pragma once

#include <cstdint>
#include <optional>

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// The whole search from a guest's vertex; none if it has not ended after a constant number of rounds.
std::optional<Certificate> double_oracle(const PairFrame& frame, std::int32_t guest_vertex, PairCounters& counters);

}  // namespace plannercheck
