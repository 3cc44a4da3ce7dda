#include "narrow_phase/pair_kernels.hpp"

#include "narrow_phase/half_space_pair.hpp"
#include "narrow_phase/part_pair.hpp"
#include "narrow_phase/solid_distance.hpp"

namespace plannercheck {
namespace {

using Contact = SolidContact (*)(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                                 PairCounters& counters, const SolidOptions& options, SolidCounters* counted);

bool hulls_share(const PosedPolytope& a, const PosedPolytope& b, const PairOptions& options, PairCounters& counters) {
  return test_pair(a, b, options, nullptr, counters).shared;
}

bool solids_share(const PosedPolytope& a, const PosedPolytope& b, const PairOptions& options, PairCounters& counters) {
  return bodies_share(test_pair(a, b, options, nullptr, counters), a, b, counters);
}

SolidContact sets_contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess,
                          PairCounters& counters, const SolidOptions& options, SolidCounters*) {
  const bool known = guess.kind == SolidContact::Kind::kParts;
  const PartContact from = known ? PartContact{true, guess.a, guess.b} : PartContact{};
  const PartContact found = parts_contact(a, b, from, counters, options.part_trees);
  return found.shared ? SolidContact{SolidContact::Kind::kParts, found.a, found.b} : SolidContact{};
}

SolidContact plane_contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact&, PairCounters& counters,
                           const SolidOptions&, SolidCounters*) {
  const PartContact found = half_space_contact(a, b, counters);
  return found.shared ? SolidContact{SolidContact::Kind::kHalfSpace, found.a, found.b} : SolidContact{};
}

template <Contact contact>
bool shares(const PosedPolytope& a, const PosedPolytope& b, const PairOptions& options, PairCounters& counters) {
  SolidOptions of_contact;
  of_contact.part_trees = options.part_trees;
  return static_cast<bool>(contact(a, b, {}, counters, of_contact, nullptr));
}

PairDistance hulls_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit,
                            PairCounters& counters, const PartVisitor* visit) {
  const PairDistance found = convex_distance(body_a, body_b, limit, counters);
  if (visit != nullptr) visit->show(body_a, body_b, found);
  return found;
}

PairDistance sets_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit, double least,
                           PairCounters& counters, const PartVisitor* visit) {
  return parts_distance(body_a, body_b, limit, least, counters, true, visit);
}

// The hulls' distance is a lower bound of the bodies'. If the bodies share a point, it is minus a depth that separates
// them; the least such depth may be smaller.
template <Contact contact, auto distance>
PairDistance past_hulls(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit, PairCounters& counters,
                        const PartVisitor* visit) {
  PairDistance hulls = convex_distance(body_a, body_b, limit, counters);
  if (hulls.lower > limit) return hulls;
  if (hulls.overlap && contact(body_a, body_b, {}, counters, {}, nullptr)) {
    hulls.upper = 0;
    return hulls;
  }
  return distance(body_a, body_b, limit, hulls.lower, counters, visit);
}

PairDistance distance_over_plane(const PosedPolytope& body_a, const PosedPolytope& body_b, double,
                                 PairCounters& counters, const PartVisitor* visit) {
  return half_space_distance(body_a, body_b, counters, visit);
}

double bound_over_plane(const PosedPolytope& body_a, const PosedPolytope& body_b, int, PairCounters& counters) {
  return half_space_distance(body_a, body_b, counters).lower;
}

}  // namespace

const KindTable<PairKernel> kPairKernels{
    {hulls_share, triangles_contact, hulls_distance, convex_bound},
    {solids_share, triangles_contact, past_hulls<triangles_contact, solid_distance>, convex_bound},
    {shares<sets_contact>, sets_contact, past_hulls<sets_contact, sets_distance>, convex_bound},
    {shares<plane_contact>, plane_contact, distance_over_plane, bound_over_plane}};

namespace {

template <auto kernel, class... Arguments>
auto by_kind(const PosedPolytope& a, const PosedPolytope& b, Arguments&&... others) {
  return (kPairKernels[kind_of(*a.body, *b.body)].*kernel)(a, b, others...);
}

}  // namespace

PairDistance pair_distance(const PosedPolytope& body_a, const PosedPolytope& body_b, double limit,
                           PairCounters& counters, const PartVisitor* visit) {
  return by_kind<&PairKernel::distance>(body_a, body_b, limit, counters, visit);
}

double distance_bound(const PosedPolytope& body_a, const PosedPolytope& body_b, int rounds, PairCounters& counters) {
  return by_kind<&PairKernel::bound>(body_a, body_b, rounds, counters);
}

bool share_a_point(const PosedPolytope& a, const PosedPolytope& b, const PairOptions& options, PairCounters& counters) {
  return by_kind<&PairKernel::share>(a, b, options, counters);
}

SolidContact contact(const PosedPolytope& a, const PosedPolytope& b, const SolidContact& guess, PairCounters& counters,
                     const SolidOptions& options, SolidCounters* counted) {
  return by_kind<&PairKernel::contact>(a, b, guess, counters, options, counted);
}

}  // namespace plannercheck
