#include "narrow_phase/pair_batch.hpp"

#include "math/interruption.hpp"
#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/inner_overlap.hpp"
#include "narrow_phase/pair_kernels.hpp"

namespace plannercheck {
namespace {

// What a batch has learnt of its pair.
struct BatchPair {
  const PairOptions& options;
  PairMemory* memory;
  PairCounters& counters;
  // Where hulls are apart, though near, trees tell that as soon (measured); so they are first given much time.
  SolidHistory history{{}, true, false, SolidHistory::kFirstPatience};
};

PairVerdict told(bool shared) {
  PairVerdict verdict;
  verdict.shared = shared;
  return verdict;
}

PairVerdict of_hulls(const PosedPolytope& body_a, const PosedPolytope& body_b, CentreAxis& axis, BatchPair& pair) {
  return test_close_pair(body_a, body_b, axis, pair.options, pair.memory, pair.counters);
}

// The hulls of a pair of solids that is no far one.
class CloseHulls final : public HullTest {
 public:
  CloseHulls(const PosedPolytope& body_a, const PosedPolytope& body_b, CentreAxis& axis, BatchPair& pair)
      : body_a_(body_a), body_b_(body_b), axis_(axis), pair_(pair) {}

  bool share() override {
    verdict_ = of_hulls(body_a_, body_b_, axis_, pair_);
    return verdict_.shared;
  }

  bool settled() const override { return verdict_.settles; }

  // What it told, if it was asked.
  const PairVerdict& verdict() const { return verdict_; }

 private:
  const PosedPolytope &body_a_, &body_b_;
  CentreAxis& axis_;
  BatchPair& pair_;
  PairVerdict verdict_;
};

// Hulls that share a point are not the last word.
PairVerdict of_solids(const PosedPolytope& body_a, const PosedPolytope& body_b, CentreAxis& axis, BatchPair& pair) {
  if (pair.options.trees_first && inner_shapes_overlap(body_a, body_b)) return told(true);
  CloseHulls hulls(body_a, body_b, axis, pair);
  const bool shared = solids_share_with(body_a, body_b, hulls, pair.options.trees_first, pair.history, pair.counters);
  PairVerdict verdict = hulls.verdict();
  verdict.shared = shared;
  return verdict;
}

// Whose hulls say nothing.
PairVerdict without_hulls(const PosedPolytope& body_a, const PosedPolytope& body_b, CentreAxis&, BatchPair& pair) {
  SolidContact& last = pair.history.contact;
  const SolidContact found = contact(body_a, body_b, last, pair.counters);
  if (found) last = found;
  return told(static_cast<bool>(found));
}

constexpr KindTable<PairVerdict (*)(const PosedPolytope&, const PosedPolytope&, CentreAxis&, BatchPair&)> kTests{
    of_hulls, of_solids, without_hulls, without_hulls};

}  // namespace

void test_pairs(const Polytope& body_a, const Polytope& body_b, std::size_t pairs, const PairOptions& options,
                PairBatch& batch, PairCounters& counters) {
  PairMemory memory;
  BatchPair pair{options, options.cached_plane && body_b.has_polar() ? &memory : nullptr, counters};
  const auto test = kTests[kind_of(body_a, body_b)];
  for (std::size_t i = 0; i < pairs; ++i) {
    poll_interruption();
    const PosedPolytope a = batch.body_a(i), b = batch.body_b(i);
    CentreAxis axis(a, b);
    if (is_far(axis, options)) {
      batch.take_far(i, axis);
    } else {
      batch.take(i, test(a, b, axis, pair));
    }
  }
}

}  // namespace plannercheck
