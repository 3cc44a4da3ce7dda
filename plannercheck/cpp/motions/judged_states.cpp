// States of motions that are judged before the motions themselves.
//
// In: motions that come at once. Out: which of them have a middle or an end that collides.
//
// The middle state of a motion comes first, since it is posed and judged together with those of other motions; then,
// where these often collide, the end. If such a state collides, no proof can call the motion free, because a proof
// covers the state as it is posed: the slack of a proof has room for the rounding of that state's numbers and of its
// pose. So the motion is refused, unless it is so large that its rounding is imprecise, which is looked at as for any
// other motion. Nothing is concluded from states that are free.
#include <algorithm>

#include "motions/motion_certifier.hpp"
#include "motions/motion_workspace.hpp"

namespace plannercheck {
namespace {

// Fewer states are judged one by one, which costs more than it saves (measured), except before sets of parts: a motion
// that collides with one is refused late, as no descent tells.
constexpr std::size_t kFewestMiddles = 3;

// Of so many motions, kTried have their middles judged to learn how often these collide, and as many of those with free
// middles their ends. If at least one in kMiddlesWorth or kEndsWorth does, all are judged: one that collides saves so
// many times what judging one costs (measured). Middles are judged at first. A tally is halved when it is full, so that
// it follows what is asked.
constexpr std::size_t kTried = 8, kMiddlesWorth = 16, kEndsWorth = 12, kRemembered = 256;

void add(StateTally& tally, const std::uint8_t* is_free, std::size_t n) {
  const auto free = static_cast<std::size_t>(std::count(is_free, is_free + n, std::uint8_t{1}));
  tally.judged += n, tally.collided += n - free;
  if (tally.judged > kRemembered) tally.judged /= 2, tally.collided /= 2;
}

// How many of the motions that come at once have their middles judged.
std::size_t worthy_middles(std::size_t count, StateTally& tally) {
  if (tally.collided * kMiddlesWorth >= tally.judged) return count;
  tally.passed_over += count;
  if (tally.passed_over < kMiddles) return 0;
  tally.passed_over = 0;
  return std::min(count, kTried);
}

}  // namespace

void MotionCertifier::judge_states(const Kinematics& kinematics, const double* q0, const double* q1, std::size_t count,
                                   Workspace& w) const {
  std::fill_n(w.is_free.begin(), count, std::uint8_t{1});
  const bool has_parts = !part_groups_.groups.empty();
  if (states_ == nullptr || (count < kFewestMiddles && !has_parts)) return;
  judge_middles(kinematics, q0, q1, has_parts ? count : worthy_middles(count, w.middles), w);
  judge_ends(kinematics, q1, count, w);
}

void MotionCertifier::judge_middles(const Kinematics& kinematics, const double* q0, const double* q1, std::size_t count,
                                    Workspace& w) const {
  const std::size_t width = at(model_.width);
  const double middle = 0.5;
  w.rows.resize(kMiddles * width);
  if (count == 0) return;
  for (std::size_t i = 0; i < count; ++i) {
    w.path.set(q0 + i * width, q1 + i * width);
    w.path.at(&middle, 1, 1, &w.rows[i * width]);
  }
  states_->check_states(kinematics, w.rows.data(), count, w.is_free.data(), *w.states);
  add(w.middles, w.is_free.data(), count);
}

// Of motions with free middles: all ends if that pays, or else few, to learn whether it does.
void MotionCertifier::judge_ends(const Kinematics& kinematics, const double* q1, std::size_t count,
                                 Workspace& w) const {
  const std::size_t width = at(model_.width);
  const bool pays = w.ends.collided * kEndsWorth > w.ends.judged;
  const std::size_t most = pays ? count : count < kMiddles ? 0 : kTried;
  std::size_t rows = 0;
  for (std::size_t i = 0; i < count && rows < most; ++i) {
    if (w.is_free[i] == 0) continue;
    std::copy_n(q1 + i * width, width, &w.rows[rows * width]);
    w.motion_of_row[rows++] = i;
  }
  if (rows == 0) return;
  states_->check_states(kinematics, w.rows.data(), rows, w.found.data(), *w.states);
  for (std::size_t row = 0; row < rows; ++row) w.is_free[w.motion_of_row[row]] = w.found[row];
  add(w.ends, w.found.data(), rows);
}

}  // namespace plannercheck
