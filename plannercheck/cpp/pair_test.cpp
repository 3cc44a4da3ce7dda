#include "pair_test.hpp"

#include <limits>

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

Vec3 between_centres(const PosedBody& guest, const PosedBody& host) {
  return guest.pose.apply(guest.body->centre) - host.pose.apply(host.body->centre);
}

// What needs no polar: the nearest points in doubles, then exact arithmetic.
PairVerdict without_polar(const PosedBody& guest, const PosedBody& host, Vec3 hint, const PairOptions& options,
                          PairCounters& counters) {
  if (options.nearest_points) {
    PairVerdict verdict;
    verdict.proximity = nearest_points(guest, host, hint, counters);
    verdict.shared = verdict.proximity.answer == Answer::kShared;
    verdict.stage = Stage::kNearest;
    if (verdict.proximity.answer != Answer::kUndecided) return verdict;
    hint = verdict.proximity.direction;
  }
  return exact_verdict(guest, host, hint, counters);
}

double conditioning(const Body& body) {
  return body.has_polar() ? body.polar_radius * body.radius : std::numeric_limits<double>::infinity();
}

}  // namespace

int choose_host(const Body& a, const Body& b) { return conditioning(b) <= conditioning(a) ? 1 : 0; }

PairVerdict test_pair(const PosedBody& guest, const PosedBody& host, const PairOptions& options, CachedPlane* cache,
                      PairCounters& counters) {
  return test_pair(PairFrame(guest, host), options, cache, counters);
}

PairVerdict test_pair(const PairFrame& frame, const PairOptions& options, CachedPlane* cache, PairCounters& counters) {
  const PosedBody &guest = frame.posed_guest(), &host = frame.posed_host();
  if (options.solver == Solver::kExact) return exact_verdict(guest, host, between_centres(guest, host), counters);
  if (!host.body->has_polar()) {
    return without_polar(guest, host, between_centres(guest, host), options, counters);
  }
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
  // Too close for the polar's bound, or within the swell of separated hulls.
  return without_polar(guest, host, host.pose.rotate(certificate.q), options, counters);
}

}  // namespace plannercheck
