#include "narrow_phase/pair_batch.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "math/interruption.hpp"
#include "narrow_phase/centre_axis.hpp"
#include "narrow_phase/double_oracle.hpp"
#include "narrow_phase/inner_overlap.hpp"
#include "narrow_phase/solid_pair.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kUnderWay = 8;  // at 100,000 vertices 3 and 4 still wait; 6 to 12 take the same time
// Least size of the inner hierarchy and the polar together; smaller ones stay in the cache (measured).
constexpr std::size_t kInterleavedVertices = 8000;
// Poses that differ by at most this many distances of neighbouring vertices, in parts of the radius, read mostly the
// same memory. Tests one by one find it in the cache, and their cached planes mostly hold. (At 1,000, 10,000 and
// 100,000 vertices interleaving pays from about 5, 5 and 2 on.)
constexpr double kWarmDistances = 5;

std::size_t vertices(const Polytope& guest, const Polytope& host) {
  return guest.inner.points.size() + host.polar.points.size();
}

// Passes the oracle's queries to descents that go step by step.
struct DeferredSupport {
  Descent& descent;
  Vec3 asked;
  bool asks_guest = false;

  bool ask_guest(const DoubleOracle<DeferredSupport>& oracle, Vec3 q) {
    asked = q, asks_guest = true;
    descent.start(oracle.frame().guest().inner, oracle.frame().guest_direction(q), oracle.counters().queries);
    return false;
  }

  bool ask_host(const DoubleOracle<DeferredSupport>& oracle, Vec3 x) {
    asked = x, asks_guest = false;
    descent.start(oracle.frame().host().polar, x, oracle.counters().queries);
    return false;
  }
};

// A test by the double oracle as in intersection.hpp, of bodies whose balls are not apart. It tries no cached plane:
// planes of other poses hardly ever hold (at most two of 300 random ones).
class SteppedTest {
 public:
  // False if the verdict is known already. `memory`: of the pair; may be null.
  bool begin(std::size_t pair, const PosedPolytope& guest, const PosedPolytope& host, const PairOptions& options,
             PairMemory* memory, PairCounters& counters) {
    pair_ = pair, options_ = &options, memory_ = memory, counters_ = &counters;
    guest_ = guest, host_ = host;
    if (!options_->centre_axis) return begin_solver(0);
    axis_.emplace(guest_, host_);
    if (axis_->centres_share()) return end(axis_->shared_by_centres());
    if (options_->turned_axis) axis_->turn();
    ++counters_->guest_queries;
    return search(&SteppedTest::after_lowest, guest_.body->inner, axis_->towards_host());
  }

  // One step of the descent; at its end, what follows from its vertex. False once the verdict is known.
  bool step() { return descent_.step(counters_->queries) || (this->*after_)(); }

  std::size_t pair() const { return pair_; }
  const PairVerdict& verdict() const { return verdict_; }

 private:
  const PairOptions* options_ = nullptr;
  PairMemory* memory_ = nullptr;
  PairCounters* counters_ = nullptr;
  std::size_t pair_ = 0;
  PosedPolytope guest_{}, host_{};
  std::optional<CentreAxis> axis_;
  std::optional<PairFrame> frame_;
  Descent descent_;
  DeferredSupport deferred_support_{descent_, {}};
  std::optional<DoubleOracle<DeferredSupport>> oracle_;
  bool (SteppedTest::*after_)() = nullptr;  // what follows the descent
  std::int32_t lowest_ = 0;
  Vec3 of_guest_, first_;
  int rounds_ = 0;
  PairVerdict verdict_;

  bool search(bool (SteppedTest::*after)(), const Levels& levels, Vec3 direction) {
    after_ = after;
    descent_.start(levels, direction, counters_->queries);
    return true;
  }

  bool end(const Certificate& certificate) {
    verdict_ = certified(certificate, memory_);
    return false;
  }

  bool after_lowest() {
    lowest_ = descent_.vertex(), of_guest_ = descent_.point();
    if (!axis_->is_beyond_centre(of_guest_)) return begin_solver(lowest_);
    ++counters_->host_queries;
    return search(&SteppedTest::after_highest, host_.body->inner, axis_->towards_guest());
  }

  bool after_highest() {
    const Certificate found = axis_->decide(of_guest_, descent_.point(), memory_ != nullptr);
    return found.answer != Answer::kUndecided ? end(found) : begin_solver(lowest_);
  }

  bool begin_solver(std::int32_t lowest) {
    lowest_ = lowest;
    frame_.emplace(guest_, host_);
    first_ = first_point(*frame_, lowest);
    ++counters_->host_queries;
    return search(&SteppedTest::after_first_facet, host_.body->polar, first_);
  }

  bool after_first_facet() {
    if (frame_->contains(dot(descent_.point(), first_))) return end(shared_at(first_));
    oracle_.emplace(*frame_, deferred_support_, *counters_);
    oracle_->start(lowest_, descent_.vertex());
    rounds_ = 0;
    after_ = &SteppedTest::after_active;
    return ask();
  }

  bool after_active() {
    const bool ended =
        deferred_support_.asks_guest
            ? oracle_->answer_guest(deferred_support_.asked, descent_.vertex(), frame_->guest_point(descent_.point()))
            : oracle_->answer_host(deferred_support_.asked, descent_.vertex(), descent_.point());
    return ended ? conclude() : ask();
  }

  bool ask() {
    if (rounds_++ == kOracleRounds) return conclude();
    oracle_->round();
    return true;
  }

  bool conclude() {
    verdict_ = concluded(guest_, host_, oracle_->certificate(), *options_, memory_, *counters_);
    return false;
  }
};

bool pays(const Polytope& guest, const Polytope& host, const PairOptions& options) {
  return options.interleaving && options.solver == Solver::kDoubleOracle && host.has_polar() &&
         vertices(guest, host) >= kInterleavedVertices;
}

void test_one_by_one(std::size_t pairs, const PairOptions& options, PairMemory* memory, PairBatch& batch,
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

// Whether a pose is close to the one before: entries of the rotation, and of the translation in parts of the bodies'
// size, differ by less than `most`. Half of the entries tell that well enough, as verdicts do not depend on it.
class Sequence {
 public:
  Sequence(double most, double size) : turned_(most), moved_(most * size) {
    last_.fill(std::numeric_limits<double>::quiet_NaN());  // the first pose follows none
  }

  bool follows(const Pose& pose) {
    const auto& m = pose.m;
    const std::array<double, 6> now{m[1], m[6], m[8], m[3], m[7], m[11]};
    bool near = true;
    for (std::size_t i = 0; i < now.size(); ++i) near &= std::fabs(now[i] - last_[i]) < (i < 3 ? turned_ : moved_);
    last_ = now;
    return near;
  }

 private:
  double turned_, moved_;
  std::array<double, 6> last_;
};

class Interleaving {
 public:
  Interleaving(const Polytope& guest, const Polytope& host, std::size_t pairs, const PairOptions& options,
               PairBatch& batch, PairMemory* memory, PairCounters& counters)
      : pairs_(pairs),
        options_(options),
        batch_(batch),
        counters_(counters),
        memory_(memory),
        guests_(kWarmDistances / std::sqrt(static_cast<double>(vertices(guest, host))), guest.radius + host.radius),
        hosts_(guests_) {}

  void run() {
    while (count_ < kUnderWay && begin(tests_[count_])) under_way_[count_] = &tests_[count_], ++count_;
    while (count_ > 0) {
      for (std::size_t k = 0; k < count_;) turn(k);
    }
  }

 private:
  std::size_t pairs_;
  const PairOptions& options_;
  PairBatch& batch_;
  PairCounters& counters_;
  std::array<SteppedTest, kUnderWay> tests_;
  std::array<SteppedTest*, kUnderWay> under_way_{};
  std::size_t next_ = 0, count_ = 0;
  PairMemory* memory_;  // null if nothing is kept
  Sequence guests_, hosts_;

  // Begins the next pair that would wait for memory, after it has tested those before it; false if there is none left.
  bool begin(SteppedTest& test) {
    while (next_ < pairs_) {
      poll_interruption();
      const std::size_t pair = next_++;
      const PosedPolytope guest = batch_.guest(pair), host = batch_.host(pair);
      if (follows(guest, host)) {
        batch_.take(pair, test_pair(guest, host, options_, memory_, counters_));
      } else if (!takes_far(pair, guest, host)) {
        if (test.begin(pair, guest, host, options_, memory_, counters_)) return true;
        batch_.take(pair, test.verdict());
      }
    }
    return false;
  }

  // Far pairs are many, and deciding one takes less time than beginning a stepped test.
  bool takes_far(std::size_t pair, const PosedPolytope& guest, const PosedPolytope& host) {
    const CentreAxis axis(guest, host);
    if (!is_far(axis, options_)) return false;
    batch_.take_far(pair, axis);
    return true;
  }

  bool follows(const PosedPolytope& guest, const PosedPolytope& host) {
    const bool guest_follows = guests_.follows(guest.pose);
    return hosts_.follows(host.pose) && guest_follows;
  }

  // One step of the test at k. When it ends, its place goes to the next pair, or to the last test under way.
  void turn(std::size_t& k) {
    SteppedTest& test = *under_way_[k];
    if (!test.step()) {
      batch_.take(test.pair(), test.verdict());
      if (!begin(test)) {
        under_way_[k] = under_way_[--count_];
        return;
      }
    }
    ++k;
  }
};

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

void test_pairs(const Polytope& guest, const Polytope& host, std::size_t pairs, const PairOptions& given,
                PairBatch& batch, PairCounters& counters) {
  if (guest.half_space || host.half_space) return test_half_spaces(pairs, batch, counters);
  PairOptions options = given;
  options.active_sets = false;  // nobody knows whether the poses are alike
  PairMemory of_pair;
  PairMemory* const memory = options.cached_plane && host.has_polar() ? &of_pair : nullptr;
  if (guest.solid || host.solid || guest.parts || host.parts) {
    test_solids(pairs, options, memory, batch, counters);
  } else if (pays(guest, host, options)) {
    Interleaving(guest, host, pairs, options, batch, memory, counters).run();
  } else {
    test_one_by_one(pairs, options, memory, batch, counters);
  }
}

}  // namespace plannercheck
