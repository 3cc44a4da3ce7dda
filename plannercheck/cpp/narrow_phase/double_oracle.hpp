// The double oracle: small active sets on both sides, vertices of A and points of B's polar. The game
// between them decides which body is queried for one more. It ends with a checked certificate, or undecided: it never
// guesses.
#pragma once

#include <cstdint>
#include <optional>

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

// The whole search from A's vertex; none if it has not ended after a constant number of rounds.
std::optional<Certificate> double_oracle(const PairFrame& frame, std::int32_t vertex_a, PairCounters& counters);

}  // namespace plannercheck
