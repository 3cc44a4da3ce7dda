#include "narrow_phase/pair_batch.hpp"

#include "math/interruption.hpp"
#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/inner_overlap.hpp"
#include "narrow_phase/solid_pair.hpp"

namespace plannercheck {
namespace {

void test_hulls(std::size_t pairs, const PairOptions& options, PairMemory* memory, PairBatch& batch,
                PairCounters& counters) {
  for (std::size_t i = 0; i < pairs; ++i) {
    poll_interruption();
    const PosedPolytope guest = batch.guest(i), host = batch.host(i);
    CentreAxis axis(guest, host);
    if (is_far(axis, options)) {
      batch.take_far(i, axis);
    } else {
      batch.take(i, test_close_pair(guest, host, axis, options, memory, counters));
    }
  }
}

// The hulls of a pair that is no far one.
class CloseHulls final : public HullTest {
 public:
  CloseHulls(const PosedPolytope& guest, const PosedPolytope& host, CentreAxis& axis, const PairOptions& options,
             PairMemory* memory, PairCounters& counters)
      : guest_(guest), host_(host), axis_(axis), options_(options), memory_(memory), counters_(counters) {}

  bool share() override {
    verdict_ = test_close_pair(guest_, host_, axis_, options_, memory_, counters_);
    return verdict_.shared;
  }

  bool settled() const override { return verdict_.settles; }

  // What it told, if it was asked.
  const PairVerdict& verdict() const { return verdict_; }

 private:
  const PosedPolytope &guest_, &host_;
  CentreAxis& axis_;
  const PairOptions& options_;
  PairMemory* memory_;
  PairCounters& counters_;
  PairVerdict verdict_;
};

// Bodies of which one is a solid: hulls that share a point are not the last word.
void test_solids(std::size_t pairs, const PairOptions& options, PairMemory* memory, PairBatch& batch,
                 PairCounters& counters) {
  // Where hulls are apart, though near, trees tell that as soon (measured); so they are first given much time.
  SolidHistory history{{}, true, false, SolidHistory::kFirstPatience};
  for (std::size_t i = 0; i < pairs; ++i) {
    poll_interruption();
    const PosedPolytope guest = batch.guest(i), host = batch.host(i);
    CentreAxis axis(guest, host);
    if (is_far(axis, options)) {
      batch.take_far(i, axis);
      continue;
    }
    if (options.trees_first && inner_shapes_overlap(guest, host)) {
      PairVerdict verdict;
      verdict.shared = true;
      batch.take(i, verdict);
      continue;
    }
    CloseHulls hulls(guest, host, axis, options, memory, counters);
    const bool shared = solids_share_with(guest, host, hulls, options.trees_first, history, counters);
    PairVerdict verdict = hulls.verdict();
    verdict.shared = shared;
    batch.take(i, verdict);
  }
}

// A half-space has no hull; its verdict is that of one vertex, or of all parts of a set.
void test_half_spaces(std::size_t pairs, PairBatch& batch, PairCounters& counters) {
  for (std::size_t i = 0; i < pairs; ++i) {
    poll_interruption();
    PairVerdict verdict;
    verdict.shared = half_space_contact(batch.guest(i), batch.host(i), counters).shared;
    batch.take(i, verdict);
  }
}

}  // namespace

void test_pairs(const Polytope& guest, const Polytope& host, std::size_t pairs, const PairOptions& options,
                PairBatch& batch, PairCounters& counters) {
  if (guest.half_space || host.half_space) return test_half_spaces(pairs, batch, counters);
  PairMemory of_pair;
  PairMemory* const memory = options.cached_plane && host.has_polar() ? &of_pair : nullptr;
  if (guest.solid || host.solid || guest.parts || host.parts) {
    test_solids(pairs, options, memory, batch, counters);
  } else {
    test_hulls(pairs, options, memory, batch, counters);
  }
}

}  // namespace plannercheck
