#include "narrow_phase/double_oracle.hpp"

namespace plannercheck {
namespace {

// Shorter searches are not worth a start of their own (measured).
constexpr int kManyRounds = 4;

// Queries both hierarchies at once, without steps.
struct AtOnce {
  bool ask_guest(DoubleOracle<AtOnce>& oracle, Vec3 q) const {
    const PairFrame& frame = oracle.frame();
    const std::int32_t v = extreme(frame.guest().inner, frame.guest_direction(q), oracle.counters().queries);
    return oracle.answer_guest(q, v, frame.guest_vertex(v));
  }

  bool ask_host(DoubleOracle<AtOnce>& oracle, Vec3 x) const {
    const PairFrame& frame = oracle.frame();
    const std::int32_t k = extreme(frame.host().polar, x, oracle.counters().queries);
    return oracle.answer_host(x, k, frame.polar_point(k));
  }
};

}  // namespace

Certificate double_oracle(const PairFrame& frame, std::int32_t guest_vertex, ActiveSet* last, PairCounters& counters) {
  const Vec3 x = first_point(frame, guest_vertex);
  ++counters.host_queries;
  const std::int32_t k = extreme(frame.host().polar, x, counters.queries);
  if (bodies_hold(frame, x, dot(frame.polar_point(k), x), 0, counters)) return shared_at(x);
  AtOnce both;
  DoubleOracle<AtOnce> oracle(frame, both, counters);
  oracle.start(guest_vertex, k);
  if (last != nullptr) oracle.join(*last);
  int rounds = 1;
  while (!oracle.round() && rounds < kOracleRounds) ++rounds;
  if (last != nullptr && rounds >= kManyRounds) *last = oracle.with_weight();
  return oracle.certificate();
}

}  // namespace plannercheck
