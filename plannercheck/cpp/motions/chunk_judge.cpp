#include "motions/chunk_judge.hpp"

#include <cmath>
#include <initializer_list>
#include <limits>

#include "math/vec.hpp"

namespace plannercheck {
namespace {

// By how much rounding moves a stop, at most, as a part of the speed, s: 1 ns by its times, which are rounded up, and
// 10 roundings of the longest stop.
constexpr double kLater = 8e-9, kLongestStop = 1e6;

// Pieces of a stop.
constexpr std::size_t kStopPieces = 8;

enum class Known { kNo, kYes, kUnsure };

// The part of its way that a joint has left, where the joint that takes longest has x² left and r times as long.
double part_left(double x, double r) {
  const double h = larger(x - (1 - r), 0) / r;
  return h * h;
}

// By how much of its way such a joint is ahead of a straight piece, at most, from x² = `from` to `to` in between.
double most_ahead(double from, double to, double r) {
  const double begin = part_left(from, r), end = part_left(to, r);
  if (!(r < 1) || !(begin > end)) return 0;
  const double slope = (begin - end) / (from * from - to * to), x = (1 - r) / (1 - r * r * slope);
  if (!(x > to && x < from)) return begin - end;  // by rounding alone
  const double straight = end + slope * (x * x - to * to);
  return larger(straight - part_left(x, r), 0);
}

class ChunkJudge {
 public:
  ChunkJudge(const GateNumbers& numbers, const double* rows, std::size_t n, const double* dq, const ChunkSteps& steps,
             const MotionJudge& judge)
      : numbers_(numbers),
        steps_(steps),
        dq_(dq),
        width_(numbers.lower.size()),
        n_(n),
        past_(n + kStopPieces),
        judge_(judge),
        rows_(rows, rows + (n + 1) * width_),
        ahead_(kStopPieces * width_),
        late_(width_),
        ends_(2 * width_),
        tube_(width_ + 1) {}

  ChunkAnswer answer() {
    Known known = keeps_limits();
    if (known == Known::kYes) known = append_stop();
    if (known != Known::kYes) return known == Known::kNo ? ChunkAnswer::kFails : ChunkAnswer::kUnknown;
    measure();
    switch (covers(0, past_)) {
      case MotionAnswer::kFree:
        return ChunkAnswer::kPasses;
      case MotionAnswer::kImprecise:
        return ChunkAnswer::kUnknown;
      case MotionAnswer::kRefused:
        break;
    }
    return answer_of_pieces();
  }

 private:
  const GateNumbers& numbers_;
  const ChunkSteps& steps_;
  const double* dq_;
  std::size_t width_, n_, past_;  // pieces of the chunk, and with those of the stop
  const MotionJudge& judge_;
  std::vector<double> rows_;  // where pieces begin and end
  std::vector<double> ahead_, late_;
  std::vector<double> way_;  // from the start to each row, by all joints
  std::vector<double> ends_, tube_;

  const double* row(std::size_t k) const { return &rows_[k * width_]; }

  // Unsure of what is no number, and of speeds and accelerations, which the plain path looks at by itself.
  Known keeps_limits() const {
    bool within = true, finite = true, slow = true;
    const double square = steps_.least * steps_.least;
    for (std::size_t c = 0; c < width_; ++c) {
      const double most = numbers_.velocity[c] * steps_.least, bend = numbers_.acceleration[c] * square;
      finite &= std::isfinite(dq_[c]);
      slow &= std::fabs(dq_[c]) <= numbers_.velocity[c];
      double before = dq_[c] * steps_.first;
      for (std::size_t k = 0; k <= n_; ++k) {
        const double q = row(k)[c];
        within &= q >= numbers_.lower[c] && q <= numbers_.upper[c];
        finite &= std::isfinite(q);
        if (k == 0) continue;
        const double moved = q - row(k - 1)[c];
        slow &= std::fabs(moved) <= most && std::fabs(moved - before) <= bend;
        before = moved;
      }
    }
    if (within && slow) return Known::kYes;
    return !within && finite ? Known::kNo : Known::kUnsure;
  }

  // The rows of the stop; whether its end is within the limits.
  Known append_stop() {
    bool within = true, beyond = false;
    std::vector<double> velocity(width_), lasts(width_);
    double longest = std::numeric_limits<double>::min();
    for (std::size_t c = 0; c < width_; ++c) {
      velocity[c] = (row(n_)[c] - row(n_ - 1)[c]) / steps_.last;
      lasts[c] = std::fabs(velocity[c]) / numbers_.brake[c];
      late_[c] = kLater * std::fabs(velocity[c]);
      longest = larger(longest, lasts[c]);
    }
    rows_.resize((past_ + 1) * width_);
    for (std::size_t c = 0; c < width_; ++c) {
      const double whole = velocity[c] * lasts[c] / 2, r = lasts[c] / longest, rest = row(n_)[c] + whole;
      within &= rest - late_[c] >= numbers_.lower[c] && rest + late_[c] <= numbers_.upper[c];
      beyond |= rest + late_[c] < numbers_.lower[c] || rest - late_[c] > numbers_.upper[c];
      for (std::size_t k = 0; k < kStopPieces; ++k) {
        const double from = at_stop(k), to = at_stop(k + 1);
        rows_[(n_ + k + 1) * width_ + c] = r > 0 ? rest - whole * part_left(to, r) : rest;
        ahead_[k * width_ + c] = r > 0 ? whole * most_ahead(from, to, r) : 0;
      }
    }
    if (within && longest <= kLongestStop) return Known::kYes;
    return beyond ? Known::kNo : Known::kUnsure;
  }

  // The square root of the part that is left, where a piece of the stop begins.
  static double at_stop(std::size_t piece) { return 1 - static_cast<double>(piece) / kStopPieces; }

  void measure() {
    way_.assign(past_ + 1, 0);
    for (std::size_t k = 0; k < past_; ++k) {
      double step = 0;
      for (std::size_t c = 0; c < width_; ++c) step += std::fabs(row(k + 1)[c] - row(k)[c]);
      way_[k + 1] = way_[k] + step;
    }
  }

  // The answer about one straight motion that covers the pieces from one row to another one.
  MotionAnswer covers(std::size_t first, std::size_t last) {
    const double whole = way_[last] - way_[first];
    for (std::size_t c = 0; c < width_; ++c) {
      const double start = row(first)[c], change = row(last)[c] - start;
      double low = 0, high = 0, before = 0;
      for (std::size_t k = first + 1; k <= last; ++k) {
        const double share = whole > 0 ? (way_[k] - way_[first]) / whole : 0;
        const double off = k < last ? row(k)[c] - (start + share * change) : 0;
        double ahead = 0, late = 0;
        if (k > n_) ahead = ahead_[(k - n_ - 1) * width_ + c], late = late_[c];
        low = smaller(low, smaller(before, off) + smaller(ahead, 0) - late);
        high = larger(high, larger(before, off) + larger(ahead, 0) + late);
        before = off;
      }
      const double aside = (low + high) / 2;
      ends_[c] = start + aside, ends_[width_ + c] = row(last)[c] + aside;
      tube_[c] = numbers_.tube[c] + (high - low) / 2;
    }
    const bool is_piece = last == first + 1 && last <= n_;
    tube_[width_] = numbers_.tube[width_] + (is_piece ? 0 : numbers_.tolerance);
    return judge_({ends_.data(), ends_.data() + width_, 1, tube_.data()});
  }

  // Where no one motion covers all.
  ChunkAnswer answer_of_pieces() {
    MotionAnswer chunk = states_at({n_, 0, n_ / 2});
    if (chunk == MotionAnswer::kFree) {
      const MotionAnswer stop = all_of(n_, past_);
      if (stop != MotionAnswer::kFree) {
        if (states_at({past_, n_ + kStopPieces / 2}) == MotionAnswer::kRefused) return ChunkAnswer::kFails;
      }
      chunk = halves(0, n_);
      if (chunk == MotionAnswer::kFree) {
        return stop == MotionAnswer::kFree ? ChunkAnswer::kPasses : ChunkAnswer::kPassesButTheStop;
      }
    }
    return chunk == MotionAnswer::kRefused ? ChunkAnswer::kFails : ChunkAnswer::kUnknown;
  }

  // The answer about the states at some rows: where one is refused, so is the chunk.
  MotionAnswer states_at(std::initializer_list<std::size_t> rows) {
    for (const std::size_t k : rows) {
      const MotionAnswer answer = judge_({row(k), row(k), 1, numbers_.tube.data()});
      if (answer != MotionAnswer::kFree) return answer;
    }
    return MotionAnswer::kFree;
  }

  // By one motion, else by halves.
  MotionAnswer all_of(std::size_t first, std::size_t last) {
    const MotionAnswer all = covers(first, last);
    return all == MotionAnswer::kRefused && last - first > 1 ? halves(first, last) : all;
  }
  MotionAnswer halves(std::size_t first, std::size_t last) {
    const std::size_t middle = (first + last + 1) / 2;
    const MotionAnswer begin = all_of(first, middle);
    return begin == MotionAnswer::kFree && middle < last ? all_of(middle, last) : begin;
  }
};

}  // namespace

ChunkAnswer judged_chunk(const GateNumbers& numbers, const double* rows, std::size_t n, const double* dq,
                         const ChunkSteps& steps, const MotionJudge& judge) {
  return ChunkJudge(numbers, rows, n, dq, steps, judge).answer();
}

}  // namespace plannercheck
