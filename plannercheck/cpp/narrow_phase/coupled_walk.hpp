// The coupled walk of Barba and Langerman, section "Detecting intersections in 3D" of the paper: O(log |P| + log |R|)
// rounds. It ends with a checked certificate, or undecided: it never guesses. Its invariants, with the polars implicit
// in the game:
//
//   separation invariant          q in conv(Q_j) with q·p > 1 for all vertices p of P_i, least at v
//   inverse separation invariant  x in P_i with q·x <= 1 for all vertices q of Q_j, largest at k
//   star invariant, primal        q_phi in conv(Q_j) with q_phi·p > 1 for all vertices p of P_i but p*
//   star invariant, polar         x_gamma in P_i with q·x_gamma <= 1 for all vertices q of Q_j but q*
//
// P_i and Q_j are the current levels of the two inner hierarchies. P* is p* with its neighbours (bounded degree, as p*
// was removed), Q* likewise; at the top of the crowns they are all vertices. Each round goes down in one of the
// hierarchies. The cone tests of Cases 2.1 and 2.2 are one game of P* against Q* and a closed form.
//
// Departures from the text: Case 1 sets no P* or p* (they would be overwritten before use). Several levels without a
// vertex beyond the plane are passed at once. Where the plane through v has a vertex p beyond it that it still
// separates (1 < q·p < q·v), v moves to p without a game.
#pragma once

#include "narrow_phase/pair_frame.hpp"

namespace plannercheck {

Certificate coupled_walk(const PairFrame& frame, PairCounters& counters);

}  // namespace plannercheck
