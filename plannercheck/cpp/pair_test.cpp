#include "pair_test.hpp"

namespace plannercheck {
namespace {

PairVerdict exact_verdict(const PosedBody& guest, const PosedBody& host, Vec3 hint, PairCounters& counters) {
  PairVerdict verdict;
  verdict.exact = decide_exactly(guest, host, hint, counters);
  verdict.shared = verdict.exact->shared;
  verdict.stage = Stage::kExact;
  return verdict;
}

PairVerdict certified(const Certificate& certificate, CachedPlane* cache) {
  PairVerdict verdict;
  verdict.certificate = certificate;
  verdict.shared = certificate.answer == Answer::kShared;
  verdict.stage = certificate.stage;
  if (cache != nullptr && !verdict.shared) *cache = {true, certificate.q, certificate.mixtures};
  return verdict;
}

}  // namespace

int choose_host(const Body& a, const Body& b) { return b.polar_radius * b.radius <= a.polar_radius * a.radius ? 1 : 0; }

PairVerdict test_pair(const PosedBody& guest, const PosedBody& host, const PairOptions& options, CachedPlane* cache,
                      PairCounters& counters) {
  if (options.solver == Solver::kExact) {
    return exact_verdict(guest, host, guest.pose.apply(guest.body->centre) - host.pose.apply(host.body->centre),
                         counters);
  }
  const PairFrame frame(guest, host);
  Certificate certificate;
  if (options.cached_plane && cache != nullptr && cache->valid &&
      still_separates(frame, cache->q, cache->mixtures, counters)) {
    certificate.answer = Answer::kSeparated;
    certificate.stage = Stage::kCachedPlane;
    certificate.q = cache->q;
    return certified(certificate, nullptr);
  }
  std::int32_t lowest = 0;
  if (options.centre_axis) {
    certificate = centre_axis(frame, &lowest, counters);
    if (certificate.answer != Answer::kUndecided) return certified(certificate, cache);
  }
  certificate =
      options.solver == Solver::kWalk ? coupled_walk(frame, counters) : double_oracle(frame, lowest, counters);
  if (certificate.answer != Answer::kUndecided) return certified(certificate, cache);
  // Too close for the polar's bound: the last plane against the vertices themselves, then exact arithmetic.
  const Vec3 direction = host.pose.rotate(certificate.q);
  if (norm_1(direction) > 0 && separates_vertices(guest, host, direction, counters)) {
    PairVerdict verdict;
    verdict.stage = Stage::kVertices;
    verdict.direction = direction;
    return verdict;
  }
  return exact_verdict(guest, host, direction, counters);
}

}  // namespace plannercheck
