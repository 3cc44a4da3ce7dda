// States of motions that are judged before the motions themselves.
//
// In: motions that come at once. Out: which of them have a state that collides, of those that are looked at.
//
// A state is posed and judged together with those of other motions, which costs a fraction of a motion. If it collides,
// no proof can call the motion free, because a proof covers the state as it is posed: the slack of a proof has room for
// the rounding of that state's numbers and of its pose. So the motion is refused, unless it is so large that its
// rounding is imprecise, which is looked at as for any other motion. Nothing is concluded from states that are free. So
// verdicts depend neither on which states are looked at (those that collided most often lately) nor on which of their
// pairs.
#include <algorithm>
#include <array>

#include "motions/motion_certifier.hpp"
#include "motions/motion_workspace.hpp"

namespace plannercheck {
namespace {

// Where motions are looked at. Planners begin motions at free states, so later states collide more often, unless the
// ends were judged before (measured).
constexpr std::array<double, kLooks> kLookAt{0.5, 0.75, 1};

// Fewer states would be judged one by one, which costs more than it saves (measured). Sets of parts are an exception:
// no descent finds collisions with them, so such motions are refused late.
constexpr std::size_t kFewestLooks = 3;

// When it is due, the first kTried motions are looked at in all places, to learn how often they collide there. If at
// least one in kFirstWorth collides at the likeliest place, all motions are looked at there; the rest then at a second
// place, by kSecondWorth. A motion found colliding saves so many times the cost of a look (measured).
constexpr std::size_t kTried = 8;
constexpr std::uint32_t kFirstWorth = 16, kSecondWorth = 12;

void add(RecentRate& rate, const std::uint8_t* is_free, std::size_t n) {
  const auto free = static_cast<std::size_t>(std::count(is_free, is_free + n, std::uint8_t{1}));
  rate.add(static_cast<std::uint32_t>(n), static_cast<std::uint32_t>(n - free));
}

// The place, other than `but`, where most of the motions collide.
std::size_t likeliest(const LookRates& rates, std::size_t but) {
  std::size_t best = but == 0 ? 1 : 0;
  for (std::size_t look = best + 1; look < kLooks; ++look) {
    if (look != but && rates[look].is_above(rates[best])) best = look;
  }
  return best;
}

}  // namespace

void MotionCertifier::judge_states(const Kinematics& kinematics, const Segments& motions, std::size_t count,
                                   Workspace& w) const {
  std::fill_n(w.is_free.begin(), count, std::uint8_t{1});
  if (states_ == nullptr || (count < kFewestLooks && !has_parts_)) return;
  std::size_t tried = 0;
  if (w.looks[0].is_due(static_cast<std::uint32_t>(count))) {
    tried = std::min(count, kTried);
    try_all_looks(kinematics, motions, tried, w);
  }
  const std::size_t first = likeliest(w.looks, kLooks);
  if (!has_parts_ && !w.looks[first].is_at_least_one_in(kFirstWorth)) return;
  judge_at(kinematics, motions, {first, tried, count}, w.looks[first], w);
  const std::size_t second = likeliest(w.later_looks[first], first);
  RecentRate& rate = w.later_looks[first][second];
  if (rate.is_at_least_one_in(kSecondWorth)) judge_at(kinematics, motions, {second, tried, count}, rate, w);
}

// Judges all looks at the first motions.
void MotionCertifier::try_all_looks(const Kinematics& kinematics, const Segments& motions, std::size_t count,
                                    Workspace& w) const {
  std::array<std::array<std::uint8_t, kTried>, kLooks> free;
  for (std::size_t look = 0; look < kLooks; ++look) {
    std::fill_n(w.is_free.begin(), count, std::uint8_t{1});
    judge_at(kinematics, motions, {look, 0, count}, w.looks[look], w);
    std::copy_n(w.is_free.begin(), count, free[look].begin());
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t first = 0; first < kLooks; ++first) {
      if (free[first][i] == 0) w.is_free[i] = 0;
      for (std::size_t second = 0; second < kLooks; ++second) {
        if (second != first && free[first][i] != 0) add(w.later_looks[first][second], &free[second][i], 1);
      }
    }
  }
}

// Judges the states at one place on those of some motions that no look has refused yet.
void MotionCertifier::judge_at(const Kinematics& kinematics, const Segments& motions, const Look& look,
                               RecentRate& rate, Workspace& w) const {
  const std::size_t width = at(model_.width);
  w.rows.resize(kMotionsAtOnce * width);
  std::size_t rows = 0;
  for (std::size_t i = look.first; i < look.past; ++i) {
    if (w.is_free[i] == 0) continue;
    w.path.set(motions[i]);
    w.path.at(&kLookAt[look.place], 1, 1, &w.rows[rows * width]);
    w.motion_of_row[rows++] = i;
  }
  if (rows == 0) return;
  states_->seek_collisions(kinematics, w.rows.data(), rows, w.found.data(), *w.states);
  for (std::size_t row = 0; row < rows; ++row) w.is_free[w.motion_of_row[row]] = w.found[row];
  add(rate, w.found.data(), rows);
}

}  // namespace plannercheck
