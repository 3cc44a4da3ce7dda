#include "motions/piece_covers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

// The largest distance between two sides of a tube, rad and m: wider ones often refuse what is free, thinner ones cover
// few pieces. Over a factor of 2 either way, trajectories take at most a fifth longer (measured).
constexpr double kWidestCover = 0x1p-5;

// So many pieces are tried first, and one cover has at most so many.
constexpr std::size_t kFirstGuess = 4, kMostCovered = 32;

// Distances from a straight motion, its middle and its ends err by fewer than 16 roundings of the largest number.
constexpr double kTubeRounding = 16 * 0x1p-53;

// A straight motion whose square is below this is a point.
constexpr double kShortestSquare = 0x1p-1000;

// Whether a piece begins where the one before ends.
bool goes_on(const Segments& pieces, std::size_t piece, std::size_t width) {
  return std::equal(pieces[piece].start, pieces[piece].start + width, pieces[piece - 1].end);
}

}  // namespace

void PieceCovers::find(const Segments& pieces, std::size_t n, std::size_t width, double tolerance,
                       const PoseRange& range) {
  width_ = width;
  first_.clear(), past_.clear(), ends_.clear(), tubes_.clear();
  std::size_t guess = kFirstGuess;
  for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
    for (end = begin + 1; end < n && goes_on(pieces, end, width);) ++end;
    if (end - begin == 1) continue;
    set_columns(pieces, begin, end);
    for (std::size_t first = begin, count = 0; first < end; first += count) {
      count = fitting(pieces.degree, first - begin, std::min(end - first, kMostCovered), guess);
      if (count == 1) continue;
      keep(pieces, first, first + count, tolerance, range);
      guess = count;
    }
  }
}

Segments PieceCovers::motions() const {
  return {ends_.data(), ends_.data() + width_, 2 * width_, 1, tubes_.data(), width_ + 1};
}

// Pieces share the points at which they meet.
void PieceCovers::set_columns(const Segments& pieces, std::size_t first, std::size_t past) {
  const std::size_t degree = pieces.degree;
  stride_ = (past - first) * degree + 1;
  columns_.resize(width_ * stride_);
  places_.resize(stride_);
  for (std::size_t i = first; i < past; ++i) {
    const std::size_t count = i + 1 < past ? degree : degree + 1;
    for (std::size_t k = 0; k < count; ++k) {
      const double* const point = pieces[i].start + k * width_;
      for (std::size_t c = 0; c < width_; ++c) columns_[c * stride_ + (i - first) * degree + k] = point[c];
    }
  }
}

// How many of at most `most` pieces a thin tube holds; `found_` becomes their deviation. Distances grow about as the
// square of the length.
std::size_t PieceCovers::fitting(std::size_t degree, std::size_t first, std::size_t most, std::size_t guess) {
  const auto fits = [&](std::size_t count) {
    measure(first * degree, (first + count) * degree, tried_);
    if (!(tried_.width <= kWidestCover)) return false;
    std::swap(found_, tried_);
    return true;
  };
  const auto may_fit = [&](std::size_t count) {
    const double longer = static_cast<double>(count) / static_cast<double>(count - 1);
    return found_.width * longer * longer <= kWidestCover;
  };
  std::size_t count = std::min(guess, most);
  const bool all_fit = count > 1 && fits(count);
  if (all_fit) {
    while (count < most && may_fit(count + 1) && fits(count + 1)) ++count;
  } else {
    do --count;
    while (count > 1 && !fits(count));
  }
  return std::max<std::size_t>(count, 1);
}

// Measures how far the control points `from` to `to` are off the straight motion, each from the place nearest to it, so
// that a robot may speed up and slow down.
void PieceCovers::measure(std::size_t from, std::size_t to, Deviation& out) {
  out.low.resize(width_), out.high.resize(width_), out.width = 0;
  std::fill(places_.begin() + static_cast<std::ptrdiff_t>(from), places_.begin() + static_cast<std::ptrdiff_t>(to) + 1,
            0.0);
  double square = 0;
  for (std::size_t c = 0; c < width_; ++c) {
    const double *const column = &columns_[c * stride_], start = column[from], along = column[to] - start;
    square += along * along;
    for (std::size_t i = from; i <= to; ++i) places_[i] += (column[i] - start) * along;
  }
  const double scale = square > kShortestSquare ? 1 / square : 0;
  for (std::size_t i = from; i <= to; ++i) places_[i] = larger(0.0, smaller(1.0, places_[i] * scale));
  for (std::size_t c = 0; c < width_; ++c) {
    const double *const column = &columns_[c * stride_], start = column[from], along = column[to] - start;
    Lanes lows{}, highs{};
    std::size_t i = from;
    for (; i + kLanes <= to; i += kLanes) {
      const Lanes off = load_lanes(column + i) - (start + load_lanes(&places_[i]) * along);
      lows = smaller(lows, off), highs = larger(highs, off);
    }
    double low = 0, high = 0;
    for (int k = 0; k < kLanes; ++k) low = smaller(low, lows[k]), high = larger(high, highs[k]);
    for (; i <= to; ++i) {
      const double off = column[i] - (start + places_[i] * along);
      low = smaller(low, off), high = larger(high, off);
    }
    out.low[c] = low, out.high[c] = high, out.width = larger(out.width, high - low);
  }
}

// The straight motion through the middle of what was found, unless its tube leaves the range.
void PieceCovers::keep(const Segments& pieces, std::size_t first, std::size_t past, double tolerance,
                       const PoseRange& range) {
  const std::size_t ends = ends_.size(), tubes = tubes_.size();
  ends_.resize(ends + 2 * width_), tubes_.resize(tubes + width_ + 1);
  double *const start = &ends_[ends], *const end = start + width_, *const tube = &tubes_[tubes];
  std::copy_n(pieces[first].tube, width_ + 1, tube);
  for (std::size_t i = first + 1; i < past; ++i) {
    for (std::size_t c = 0; c <= width_; ++c) tube[c] = larger(tube[c], pieces[i].tube[c]);
  }
  for (std::size_t c = 0; c < width_; ++c) {
    const double a = pieces[first].start[c], e = pieces[past - 1].end[c], low = found_.low[c], high = found_.high[c];
    const double largest = larger(std::fabs(a), std::fabs(e)) + larger(-low, high);
    start[c] = a + (low + high) / 2;
    end[c] = e + (low + high) / 2;
    tube[c] = (tube[c] + (high - low) / 2 + kTubeRounding * largest) * (1 + 0x1p-51);
  }
  tube[width_] = (tube[width_] + tolerance) * (1 + 0x1p-52);
  if (stays_within({start, end, 1, tube}, width_, range.low, range.high)) {
    first_.push_back(first), past_.push_back(past);
  } else {
    ends_.resize(ends), tubes_.resize(tubes);
  }
}

}  // namespace plannercheck
