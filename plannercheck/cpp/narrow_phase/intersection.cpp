#include "narrow_phase/intersection.hpp"

#include <limits>

#include "narrow_phase/box_faces.hpp"
#include "narrow_phase/coupled_walk.hpp"
#include "narrow_phase/double_oracle.hpp"

namespace plannercheck {
namespace {

PairVerdict exact_verdict(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start) {
  PairVerdict verdict;
  verdict.exact = decide_exactly(body_a, body_b, start);
  verdict.shared = verdict.exact->shared;
  verdict.stage = Stage::kExact;
  return verdict;
}

PairVerdict near_verdict(const Proximity& proximity, Stage stage) {
  PairVerdict verdict;
  verdict.proximity = proximity;
  verdict.shared = proximity.answer == Answer::kShared;
  verdict.stage = stage;
  return verdict;
}

Proximity along(Vec3 direction) {
  Proximity start;
  start.direction = direction;
  return start;
}

// The verdict where hulls meet no deeper than the bodies' dents, or hardly: the bodies stay open.
PairVerdict open_verdict() {
  PairVerdict verdict;
  verdict.shared = true;
  verdict.settles = false;
  return verdict;
}

// The stage after the solver where dents count: hulls that share a point may be the bodies' only if they are inflated.
PairVerdict within_hull_excess(const PosedPolytope& body_a, const PosedPolytope& body_b, Vec3 hint,
                               PairCounters& counters) {
  if (body_a.body->inflation_radius + body_b.body->inflation_radius == 0) return open_verdict();
  const Proximity found = nearest_points(body_a, body_b, hint, counters, true);
  return found.answer == Answer::kUndecided ? open_verdict() : near_verdict(found, Stage::kNearest);
}

// Decides whether a verdict on hulls also holds for the bodies. Filters and solvers report only overlaps deeper than
// the dents; centres and vertices belong to dented bodies, too.
void settle(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairOptions& options,
            PairVerdict& verdict) {
  if (!verdict.shared) return;
  const bool dents_count = options.dents && verdict.stage <= Stage::kNearest;
  verdict.settles &=
      dents_count ? equal_their_hulls(body_a, body_b) : body_a.body->dents.deepest + body_b.body->dents.deepest == 0;
}

// The stages that need no polar: nearest points in doubles, then in double-double, then exact arithmetic.
PairVerdict without_polar(const PosedPolytope& body_a, const PosedPolytope& body_b, Vec3 hint,
                          const PairOptions& options, PairCounters& counters) {
  if (options.dents && have_dents(body_a, body_b)) return within_hull_excess(body_a, body_b, hint, counters);
  Proximity found = along(hint);
  if (options.nearest_points) {
    found = nearest_points(body_a, body_b, hint, counters);
    if (found.answer != Answer::kUndecided) return near_verdict(found, Stage::kNearest);
  }
  if (!options.warm_start) found = along(found.direction);
  if (options.double_double) {
    found = nearest_points_double_double(body_a, body_b, found, counters);
    if (found.answer != Answer::kUndecided) return near_verdict(found, Stage::kDoubleDouble);
  }
  return exact_verdict(body_a, body_b, options.warm_start ? found : along(found.direction));
}

// Takes O(log n + log m) steps with either solver: the oracle has a constant number of rounds, after which the walk
// goes on. Both leave open only gaps too small for the polar's bound, and hulls apart by less than their inflation
// radius.
Certificate solver_certificate(const PairFrame& frame, std::int32_t lowest, Solver solver, PairCounters& counters) {
  if (solver == Solver::kDoubleOracle) {
    if (const std::optional<Certificate> found = double_oracle(frame, lowest, counters)) return *found;
  }
  return coupled_walk(frame, counters);
}

// The stages that cost a game: the solver, then, where it does not apply or decide, the stages without a polar.
PairVerdict solved(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairFrame& frame,
                   std::int32_t lowest, const CentreAxis& axis, const PairOptions& options, PairMemory* memory,
                   PairCounters& counters) {
  if (!body_b.body->has_polar()) return without_polar(body_a, body_b, axis.direction(), options, counters);
  const Certificate certificate = solver_certificate(frame, lowest, options.solver, counters);
  if (certificate.answer != Answer::kUndecided) return certified(certificate, memory);
  return without_polar(body_a, body_b, body_b.pose.rotate(certificate.q), options, counters);
}

// The memory for the next poses of this pair; null if nothing is kept.
PairMemory* kept(const Polytope& body_b, const PairOptions& options, PairMemory* memory) {
  return options.cached_plane && body_b.has_polar() ? memory : nullptr;
}

// Whether the plane that separated this pair at earlier poses separates it now.
[[gnu::always_inline]] inline bool plane_holds(const PairFrame& frame, const PairMemory* memory,
                                               PairCounters& counters) {
  if (memory == nullptr || !memory->plane.valid) return false;
  const auto& [q, mixtures, valid] = memory->plane;
  ++counters.queries_a;
  const std::int32_t p = extreme(frame.body_a().inner, frame.direction_a(q), counters.queries);
  return frame.separates(q, dot(q, frame.vertex_a(p)), mixtures);
}

Certificate by_box_face(const PairFrame& frame, const PairOptions& options, PairCounters& counters) {
  return options.box_face && frame.body_b().has_polar() ? box_face(frame, counters) : Certificate{};
}

PairVerdict cached(const CachedPlane& plane) {
  PairVerdict verdict;
  verdict.stage = verdict.certificate.stage = Stage::kCachedPlane;
  verdict.certificate.answer = Answer::kSeparated;
  verdict.certificate.q = plane.q;
  return verdict;
}

double conditioning(const Polytope& body) {
  return body.has_polar() ? body.polar_radius * body.radius : std::numeric_limits<double>::infinity();
}

}  // namespace

PairVerdict certified(const Certificate& certificate, PairMemory* memory) {
  PairVerdict verdict;
  verdict.certificate = certificate;
  verdict.shared = certificate.answer == Answer::kShared;
  verdict.stage = certificate.stage;
  if (memory != nullptr && !verdict.shared) {
    memory->plane = {certificate.q, static_cast<std::int32_t>(certificate.mixtures), true};
  }
  return verdict;
}

FoundDirection direction_found(const PairVerdict& verdict, const PosedPolytope& body_b) {
  if (verdict.exact) {
    const DoubleDoubleVec3 near = direction_of(verdict.exact->direction);
    return {{near.x.high, near.y.high, near.z.high}, verdict.exact->direction};
  }
  const Vec3 found = verdict.proximity.direction;
  if (verdict.stage == Stage::kNearest) return {found, std::nullopt};
  if (verdict.stage == Stage::kDoubleDouble) {
    return {found, DyadicVec3(found) + DyadicVec3(verdict.proximity.direction_low)};
  }
  return {body_b.pose.rotate(verdict.certificate.q), std::nullopt};
}

int choose_b(const Polytope& a, const Polytope& b) { return conditioning(b) <= conditioning(a) ? 1 : 0; }

PairVerdict test_pair(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairOptions& options,
                      PairMemory* memory, PairCounters& counters) {
  CentreAxis axis(body_a, body_b);
  if (!is_far(axis, options)) return test_close_pair(body_a, body_b, axis, options, memory, counters);
  memory = kept(*body_b.body, options, memory);
  return certified(axis.separated(memory != nullptr), memory);
}

namespace {

PairVerdict close_hulls_verdict(const PosedPolytope& body_a, const PosedPolytope& body_b, CentreAxis& axis,
                                const PairOptions& options, PairMemory* memory, PairCounters& counters) {
  if (options.solver == Solver::kExact) return exact_verdict(body_a, body_b, along(axis.direction()));
  memory = kept(*body_b.body, options, memory);
  std::int32_t lowest = 0;
  if (options.centre_axis) {
    if (options.turned_axis) axis.turn();
    const Certificate found = axis.decide(memory != nullptr, &lowest, counters);
    if (found.answer != Answer::kUndecided) return certified(found, memory);
  }
  const PairFrame frame(body_a, body_b, options.dents);
  if (plane_holds(frame, memory, counters)) return cached(memory->plane);
  return solved(body_a, body_b, frame, lowest, axis, options, memory, counters);
}

PairVerdict hulls_verdict(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairFrame& frame, bool likely,
                          const PairOptions& options, PairMemory* memory, PairCounters& counters) {
  if (options.solver == Solver::kExact) {
    return exact_verdict(body_a, body_b, along(CentreAxis(body_a, body_b).direction()));
  }
  memory = kept(*body_b.body, options, memory);
  if (plane_holds(frame, memory, counters)) return cached(memory->plane);
  if (!likely) {
    const Certificate found = by_box_face(frame, options, counters);
    if (found.answer != Answer::kUndecided) return certified(found, memory);
  }
  CentreAxis axis(body_a, body_b);
  std::int32_t lowest = 0;
  if (likely && !axis.has_inflation_radius()) {
    lowest = axis.nearly_lowest(counters);
  } else if (options.centre_axis) {
    if (options.turned_axis) axis.turn();
    const Certificate found = axis.decide(memory != nullptr, &lowest, counters);
    if (found.answer != Answer::kUndecided) return certified(found, memory);
  }
  return solved(body_a, body_b, frame, lowest, axis, options, memory, counters);
}

}  // namespace

PairVerdict test_close_pair(const PosedPolytope& body_a, const PosedPolytope& body_b, CentreAxis& axis,
                            const PairOptions& options, PairMemory* memory, PairCounters& counters) {
  PairVerdict verdict = close_hulls_verdict(body_a, body_b, axis, options, memory, counters);
  settle(body_a, body_b, options, verdict);
  return verdict;
}

PairVerdict test_pair(const PosedPolytope& body_a, const PosedPolytope& body_b, const PairFrame& frame, bool likely,
                      const PairOptions& options, PairMemory* memory, PairCounters& counters) {
  PairVerdict verdict = hulls_verdict(body_a, body_b, frame, likely, options, memory, counters);
  settle(body_a, body_b, options, verdict);
  return verdict;
}

}  // namespace plannercheck
