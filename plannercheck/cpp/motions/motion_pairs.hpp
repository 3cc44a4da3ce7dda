// What the check of a motion asks of one pair on the current grid, by the kinds of its bodies.
//
// In: the grid and the bounds that a run has placed. Out: the functions that adaptive_subdivision.hpp names: which
// intervals filters leave open, gaps and descents, what settles an interval, what is clear or touches at a state. A
// pair passes spheres, boxes along the plane found last, and hulls along planes of earlier motions, which are hints.
// What differs by the kind of a pair is a row of `kMotionKernels`.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"
#include "motions/adaptive_subdivision.hpp"
#include "motions/clearance_screen.hpp"
#include "motions/motion_certifier.hpp"
#include "motions/motion_collisions.hpp"
#include "motions/motion_filters.hpp"
#include "motions/motion_workspace.hpp"
#include "motions/part_separation.hpp"
#include "motions/solid_separation.hpp"
#include "narrow_phase/distance.hpp"
#include "narrow_phase/half_space_pair.hpp"
#include "narrow_phase/pair_kernels.hpp"
#include "narrow_phase/part_pair.hpp"

namespace plannercheck {

// A hint is tried only if the boxes overlap along it by at most this part of the smaller body's radius: deeper, the
// hulls would have to leave that much of their boxes empty, which few do (a sixth of the Panda's pairs).
inline constexpr double kDeepestHint = 1;

class MotionPairs : public AdaptiveSubdivision<MotionPairs, SpatialMotions> {
 protected:
  friend AdaptiveSubdivision;

  MotionPairs(const MotionCertifier& certifier, const Kinematics& kinematics, double tolerance,
              MotionCertifier::Workspace& workspace)
      : AdaptiveSubdivision(certifier.model_.pairs, workspace),
        certifier_(certifier),
        model_(certifier.model_),
        tuning_(certifier.tuning_),
        kinematics_(kinematics),
        tolerance_(tolerance),
        filters_(model_, certifier.defects_, workspace.grid, workspace.bounds) {}

  const MotionCertifier& certifier_;
  const MotionModel& model_;
  const Tuning& tuning_;
  const Kinematics& kinematics_;
  double tolerance_;
  MotionFilters filters_;
  MotionGrid::Choice* posed_ = nullptr;  // what the grids pose

  // ----- by the kind of a pair

  // What the methods of these names do.
  struct MotionKernels {
    unsigned (MotionPairs::*near)(std::int32_t index);
    DirectedPair (MotionPairs::*found_open)(std::int32_t index, unsigned near);
    double (MotionPairs::*gap_at)(const CertifiedPair& pair, const PosedPair& posed, Vec3 direction);
    SweptAnswer<Vec3> (MotionPairs::*swept)(const CertifiedPair& pair, const PosedPair* posed, int count, double limit,
                                            Vec3 hint);
    bool (MotionPairs::*touches)(PairState& s, std::size_t state);
    bool (MotionPairs::*proves_clear)(PairState& s, std::size_t state, double limit);
    bool (MotionPairs::*parts_settle)(PairState& s, std::size_t i);
    bool has_planes = true;  // whether hulls along planes tell anything
  };
  static const KindTable<MotionKernels> kMotionKernels;

  const MotionKernels& of(const CertifiedPair& pair) const { return kMotionKernels[pair.kind]; }
  static bool are_hulls(const CertifiedPair& pair) { return pair.kind == Kind::kHull; }

  // Most pairs are two hulls: they need no call through a pointer where time counts.
  unsigned near(std::int32_t index) {
    const CertifiedPair& pair = pairs_[at(index)];
    return are_hulls(pair) ? filters_.near(pair) : (this->*of(pair).near)(index);
  }
  DirectedPair found_open(std::int32_t index, unsigned near) {
    const CertifiedPair& pair = pairs_[at(index)];
    return are_hulls(pair) ? hulls_open(index, near) : (this->*of(pair).found_open)(index, near);
  }
  double gap_at(const CertifiedPair& pair, const PosedPair& posed, Vec3 direction) {
    return are_hulls(pair) ? hulls_gap(pair, posed, direction) : (this->*of(pair).gap_at)(pair, posed, direction);
  }
  SweptAnswer<Vec3> swept(const CertifiedPair& pair, const PosedPair* posed, int count, double limit, Vec3 hint) {
    return are_hulls(pair) ? swept_hulls(pair, posed, count, limit, hint)
                           : (this->*of(pair).swept)(pair, posed, count, limit, hint);
  }
  // Whether the pair shares a point at a state; then no interval there can be settled.
  bool touches(PairState& s, std::size_t state) { return (this->*of(s.pair).touches)(s, state); }
  bool proves_clear(PairState& s, std::size_t state) {
    return (this->*of(s.pair).proves_clear)(s, state, tolerance_ + filters_.shift(s.pair) - 2 * filters_.slack());
  }
  // Recorded proofs prove hulls apart, so parts settle nothing there.
  bool parts_settle(PairState& s, std::size_t i) {
    return !are_hulls(s.pair) && proofs_ == nullptr && (this->*of(s.pair).parts_settle)(s, i);
  }
  bool share_a_point(const PairState& s, const PosedPair& pose) {
    return kPairKernels[s.pair.kind].share(posed_a(s, pose), posed_b(s, pose), tuning_, w_.counters.pair);
  }
  bool has_planes(const PairState& s) const { return proofs_ != nullptr || of(s.pair).has_planes; }

  // ----- grids

  void pose_grid(double from, double to, int intervals) { w_.grid.place(*posed_, w_.path, from, to, intervals); }

  void choose(const std::vector<std::int32_t>& pairs) {
    w_.bodies.clear(), w_.frames.clear();
    for (const std::int32_t index : pairs) {
      const CertifiedPair& pair = model_.pairs[at(index)];
      for (const std::int32_t b : {pair.a, pair.b}) {
        if (!filters_.stands_still(b)) w_.bodies.push_back(b);
      }
      if (pair.frame >= 0) w_.frames.push_back(pair.frame);
    }
    w_.chosen = w_.grid.choice(kinematics_, w_.bodies, w_.frames);
    posed_ = &w_.chosen;
  }

  // ----- what filters leave open

  unsigned near_hulls(std::int32_t index) { return filters_.near(pairs_[at(index)]); }
  unsigned near_plane(std::int32_t index) {
    return filters_.near_plane(pairs_[at(index)], plane_of(pairs_[at(index)]));
  }

  // Looks up clearances, by twice the tolerance, as bounds of speed do: most sets of parts reach around the robot, so
  // bounding spheres leave out little.
  unsigned near_parts(std::int32_t index) {
    const unsigned near = filters_.all_intervals();
    if (proofs_ != nullptr || !tuning_.part_trees || !tuning_.bounds) return near;
    return near_by_clearances(*certifier_.clearances_, pairs_[at(index)], filters_, w_.grid, 2 * tolerance_, near);
  }

  bool begin_collisions() {
    if (tuning_.overlaps) certifier_.collisions_->begin(w_.grid, w_.collisions);
    return tuning_.overlaps;
  }

  bool surely_collides(const NearPair& near) {
    const int state = certifier_.collisions_->colliding_state(near, w_.collisions);
    return state >= 0 && !refuse_at(w_.grid.parameter(at(state)), near.pair);
  }

  // The intervals that boxes leave open, along the plane found last and along a direction taken from the boxes.
  DirectedPair hulls_open(std::int32_t index, unsigned near) {
    const CertifiedPair& pair = model_.pairs[at(index)];
    const Plane<Vec3>& plane = w_.planes[at(index)];
    DirectedPair found{{index, near, 0, 0}, {}};
    if (proofs_ == nullptr && plane.motion != 0) {
      if (plane.motion == w_.motion) {
        filters_.boxes_settle(found, plane.direction);
      } else if (hint_settles(pair, found, plane.direction)) {
        found.open = 0;
      }
      if (found.open == 0) return found;
    }
    // The bodies are mostly nearest in the middle of the open intervals.
    const int first = __builtin_ctz(found.open), last = 32 - __builtin_clz(found.open);
    found.direction = filters_.between(pair, static_cast<std::size_t>((first + last) / 2));
    if (proofs_ == nullptr) filters_.boxes_settle(found, found.direction);
    return found;
  }

  // Only its own normal separates a half-space, which stands still, from a body.
  DirectedPair plane_open(std::int32_t index, unsigned near) {
    return {{index, near, 0, 0}, plane_of(model_.pairs[at(index)]).normal};
  }

  // No single plane belongs to all parts.
  DirectedPair parts_open(std::int32_t index, unsigned near) {
    if (proofs_ != nullptr) return hulls_open(index, near);
    return {{index, open_parts(index, near), 0, 0}, {}};
  }

  // The intervals of `near` that stay open after one look at all of them together.
  unsigned open_parts(std::int32_t index, unsigned near) {
    const CertifiedPair& pair = pairs_[at(index)];
    // One interval is looked at when it is settled.
    if (!tuning_.bounds || !tuning_.part_trees || (near & (near - 1)) == 0) return near;
    std::array<PosedPair, kGridStates> poses;
    int count = 0;
    for (unsigned states = near | near << 1; states != 0; states &= states - 1) {
      poses[at(count++)] = filters_.posed(pair, static_cast<std::size_t>(__builtin_ctz(states)));
    }
    return parts_stay_further(pair, poses.data(), count, filters_.apart(pair)) ? 0 : near;
  }

  bool parts_stay_further(const CertifiedPair& pair, const PosedPair* poses, int count, double limit) {
    return parts_further(filters_.body(pair.a), filters_.body(pair.b), poses, count, limit, w_.counters.pair,
                         tuning_.part_trees);
  }

  // Whether a plane of an earlier motion keeps the pair more than twice the tolerance apart wherever it is open. Then
  // no state of this motion is within the tolerance. Without hints a pair is refused only by such a state, so it would
  // be settled as well. A hint that leaves any interval open is discarded.
  bool hint_settles(const CertifiedPair& pair, const DirectedPair& found, Vec3 direction) {
    if (ordered_ || !tuning_.cached_plane) return false;
    DirectedPair left = found;
    filters_.boxes_settle(left, direction, 2 * tolerance_);
    if (left.open == 0) return true;
    const double radius = smaller(filters_.body(pair.a).radius, filters_.body(pair.b).radius);
    if (left.depth < -kDeepestHint * radius) return false;
    const double apart = filters_.apart(pair) + 2 * tolerance_, way = filters_.speed(pair) * w_.grid.step();
    double gap = 0;
    int looked_at = -1;
    for (unsigned states = left.open | left.open << 1; states != 0; states &= states - 1) {
      const int state = __builtin_ctz(states);
      // From one state to the next, the gap shrinks by at most the distance that the bodies travel.
      if (looked_at >= 0 && gap - way * (state - looked_at) > apart) continue;
      const PosedPair posed = filters_.posed(pair, static_cast<std::size_t>(state));
      ++w_.counters.planes;
      gap = gap_at(pair, posed, direction);
      if (!(gap > apart)) return false;
      looked_at = state;
    }
    return true;
  }

  // ----- one pair on one grid

  static Vec3 first_direction(const DirectedPair& found) { return found.direction; }
  double apart(std::int32_t index) const { return filters_.apart(pairs_[at(index)]); }
  PosedPair poses(const CertifiedPair& pair, std::size_t state) { return filters_.posed(pair, state); }

  WorldPlane plane_of(const CertifiedPair& pair) const {
    return world_plane(filters_.body(pair.b).as<HalfSpace>(), model_.bodies[at(pair.b)].placement);
  }
  double height_at(const CertifiedPair& pair, const PosedPair& posed, Vec3) {
    return height_over({&filters_.body(pair.b), posed.b}, {&filters_.body(pair.a), posed.a}, w_.counters.pair);
  }

  double hulls_gap(const CertifiedPair& pair, const PosedPair& posed, Vec3 direction) {
    return gap_along(filters_.body(pair.a), filters_.body(pair.b), posed, direction, w_.counters.pair);
  }

  SweptAnswer<Vec3> swept_hulls(const CertifiedPair& pair, const PosedPair* posed, int count, double limit, Vec3 hint) {
    return swept_distance(filters_.body(pair.a), filters_.body(pair.b), posed, count, limit, hint, w_.counters.pair);
  }

  SweptAnswer<Vec3> swept_over_plane(const CertifiedPair& pair, const PosedPair* posed, int count, double limit,
                                     Vec3 normal) {
    SweptAnswer<Vec3> answer;
    answer.direction = normal, answer.gap = height_at(pair, posed[0], normal);
    for (int p = 1; p < count; ++p) answer.gap = smaller(answer.gap, height_at(pair, posed[p], normal));
    answer.apart = answer.gap > limit;
    return answer;
  }

  MotionProof proof(const PairState& s, double from, double to, double least) const {
    const double gap = least - filters_.inflation_radii(s.pair) - filters_.slack();
    return {s.index, from, to, s.plane.direction, gap, filters_.chord_deviation(s.pair)};
  }

  // A pair that is clear at both ends may still be settled.
  bool fail(PairState& s, std::size_t i) {
    const double refused = end_within(s, i);
    if (refused < 0 && (planes_settle(s, i) || is_short(s))) {
      prove(s, i);
      return true;
    }
    return leave(s, i, refused);
  }

  // Whether a pair clear at an end cannot meet on an interval, as its bodies travel less than the tolerance.
  bool is_short(const PairState& s) {
    const double way = filters_.speed(s.pair) * w_.grid.step();
    const double deviation = filters_.chord_deviation(s.pair) - filters_.shift(s.pair);
    return way + deviation + 4 * filters_.slack() <= tolerance_;
  }

  bool hulls_clear(PairState& s, std::size_t state, double limit) {
    return is_apart(s, state, limit) || is_further(s, state, limit);
  }

  // Whether two solids are more than the limit apart at a state: their triangles, and neither is in the other one.
  bool solids_clear(PairState& s, std::size_t state, double limit) {
    if (is_apart(s, state, limit)) return true;
    const PosedPair pose = filters_.posed(s.pair, state);
    return solids_stay_further(s, &pose, 1, limit + filters_.inflation_radii(s.pair));
  }

  // Whether all parts of a set are more than the limit from the other body at a state.
  bool parts_clear(PairState& s, std::size_t state, double limit) {
    const PosedPair pose = filters_.posed(s.pair, state);
    const double further = limit + filters_.inflation_radii(s.pair);
    const bool trees = tuning_.part_trees;
    if (trees && parts_stay_further(s.pair, &pose, 1, further)) return true;
    return !share_a_point(s, pose) &&
           parts_distance(posed_a(s, pose), posed_b(s, pose), limit, 0, w_.counters.pair, trees).lower > limit;
  }

  bool planes_settle(PairState& s, std::size_t i) { return has_planes(s) && plane_settles(s, i); }
  bool hulls_settle(PairState& s, std::size_t i) {
    return has_planes(s) && (plane_settles(s, i) || sweep_settles(s, i));
  }

  // The triangles of two solids keep apart on an interval if the same holds for each pair of them as for hulls. Then
  // neither body can get into the other one between the ends.
  bool solids_settle(PairState& s, std::size_t i) {
    if (goes_beyond_dents(s)) return false;
    const std::array<PosedPair, 2> ends{filters_.posed(s.pair, i), filters_.posed(s.pair, i + 1)};
    return solids_stay_further(s, ends.data(), 2, s.apart);
  }
  bool solids_stay_further(const PairState& s, const PosedPair* poses, int count, double limit) {
    return solids_further(filters_.body(s.pair.a), filters_.body(s.pair.b), poses, count, limit) &&
           !are_nested(posed_a(s, poses[0]), posed_b(s, poses[0]));
  }

  bool sets_settle(PairState& s, std::size_t i) {
    const std::array<PosedPair, 2> ends{filters_.posed(s.pair, i), filters_.posed(s.pair, i + 1)};
    return parts_stay_further(s.pair, ends.data(), 2, s.apart) || stays_in_hollow(s, i);
  }
  // No plane keeps parts in the hollow of a solid from all of it, but they may be further from it than they go, by
  // twice the tolerance: then no state of the interval is within it, and smaller ones would be settled as well.
  bool stays_in_hollow(PairState& s, std::size_t i) {
    if (!tuning_.hollows) return false;
    if (!may_be_hollow(s.pair.a) && !may_be_hollow(s.pair.b)) return false;
    const double way = filters_.speed(s.pair) * w_.grid.step();
    return parts_clear(s, i, s.apart - filters_.inflation_radii(s.pair) + way + 2 * tolerance_);
  }

  bool may_be_hollow(std::int32_t body) const {
    const KindTraits& traits = filters_.body(body).traits();
    return !traits.is_convex && !traits.has_parts;
  }

  bool nothing_settles(PairState&, std::size_t) { return false; }

  // Whether the bodies travel so far on an interval that their dents hardly matter: then triangles settle no more than
  // hulls (for Talos' torso 0 of 17 intervals of 0.01 to 0.3 radii, at 5 percent of a motion's time).
  bool goes_beyond_dents(const PairState& s) const {
    constexpr double kBeyondDents = 0.25;
    return filters_.speed(s.pair) * w_.grid.step() > kBeyondDents * dents(s.pair);
  }
  // How far points of hulls are at most from points of the bodies, in m; infinite where that is not known.
  double dents(const CertifiedPair& pair) const {
    if (!tuning_.dents && !are_hulls(pair)) return kUnknownDent;
    return reach_of_dents(filters_.body(pair.a), filters_.body(pair.b));
  }

  // The descent ends early where its simplices are flat. The proved bound of the distance decides on refusal.
  bool is_further(PairState& s, std::size_t state, double limit) {
    const PosedPair pose = filters_.posed(s.pair, state);
    if (share_a_point(s, pose)) return false;  // pair_distance would go on to the penetration depth
    const PairDistance found = pair_distance(posed_a(s, pose), posed_b(s, pose), limit, w_.counters.pair);
    if (!(found.lower > limit)) return false;
    learn(s, pose.frame.from_world(found.direction));
    return true;
  }

  bool share_at(PairState& s, std::size_t state) { return share_a_point(s, filters_.posed(s.pair, state)); }

  bool hulls_touch(PairState& s, std::size_t state) {
    const SweptAnswer<Vec3> answer = sweep_at(s, state, filters_.slack() + filters_.inflation_radii(s.pair));
    if (answer.apart) return false;
    // The descent ends with differences of the hulls around the origin. Each errs by less than the slack, and dents
    // move it by at most their depth.
    return answer.inside > filters_.slack() + dents(s.pair) || share_at(s, state);
  }

  PosedPolytope posed_a(const PairState& s, const PosedPair& pose) { return {&filters_.body(s.pair.a), pose.a}; }
  PosedPolytope posed_b(const PairState& s, const PosedPair& pose) { return {&filters_.body(s.pair.b), pose.b}; }

  bool is_apart(PairState& s, std::size_t state, double limit) {
    return sweep_at(s, state, limit + filters_.inflation_radii(s.pair)).apart;
  }
};

inline const KindTable<MotionPairs::MotionKernels> MotionPairs::kMotionKernels{
    {&MotionPairs::near_hulls, &MotionPairs::hulls_open, &MotionPairs::hulls_gap, &MotionPairs::swept_hulls,
     &MotionPairs::hulls_touch, &MotionPairs::hulls_clear, &MotionPairs::nothing_settles},
    {&MotionPairs::near_hulls, &MotionPairs::hulls_open, &MotionPairs::hulls_gap, &MotionPairs::swept_hulls,
     &MotionPairs::hulls_touch, &MotionPairs::solids_clear, &MotionPairs::solids_settle},
    {&MotionPairs::near_parts, &MotionPairs::parts_open, &MotionPairs::hulls_gap, &MotionPairs::swept_hulls,
     &MotionPairs::share_at, &MotionPairs::parts_clear, &MotionPairs::sets_settle, false},
    // Against a half-space, only the hull of the other body counts.
    {&MotionPairs::near_plane, &MotionPairs::plane_open, &MotionPairs::height_at, &MotionPairs::swept_over_plane,
     &MotionPairs::share_at, &MotionPairs::hulls_clear, &MotionPairs::nothing_settles}};

}  // namespace plannercheck
