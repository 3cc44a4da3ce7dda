#include "bodies/height_ceilings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plannercheck {
namespace {

// Cells of the finest level at most: half a MB, which stays in a cache. Finer cells would tell more of a field of 4096
// x 4096 heights, and take longer (measured).
constexpr std::size_t kMostFinest = std::size_t{1} << 18;

constexpr std::uint16_t kMostUnits = std::numeric_limits<std::uint16_t>::max();

// Units of the highest height. The rest is for rounding.
constexpr double kUnits = kMostUnits - 15;

// Shorter ones would not be exact, m.
constexpr double kShortestUnit = 1e-30;

std::size_t cells_over(std::size_t squares, std::size_t side) { return (squares + side - 1) / side; }

}  // namespace

// The greatest heights over cells.
struct HeightCeilings::Cells {
  std::size_t rows, columns;
  std::vector<std::uint16_t> value;

  std::uint16_t greatest(std::size_t from_i, std::size_t past_i, std::size_t from_j, std::size_t past_j) const {
    std::uint16_t most = 0;
    for (std::size_t i = from_i; i < std::min(past_i, rows); ++i) {
      for (std::size_t j = from_j; j < std::min(past_j, columns); ++j) most = std::max(most, value[i * columns + j]);
    }
    return most;
  }
  std::uint16_t near(std::size_t i, std::size_t j) const {
    return greatest(i - std::min<std::size_t>(i, 1), i + 2, j - std::min<std::size_t>(j, 1), j + 2);
  }
  Cells halved() const {
    Cells out{cells_over(rows, 2), cells_over(columns, 2), {}};
    for (std::size_t i = 0; i < out.rows; ++i) {
      for (std::size_t j = 0; j < out.columns; ++j) out.value.push_back(greatest(2 * i, 2 * i + 2, 2 * j, 2 * j + 2));
    }
    return out;
  }
};

namespace {

// The greatest of `base` and the heights at the corners of each cell's squares; a comparison with NaN is false.
std::vector<double> highest_over_cells(const double* heights, std::size_t rows, std::size_t columns, std::size_t side,
                                       double base) {
  std::vector<double> out, along(columns);
  for (std::size_t first = 0; first + 1 < rows; first += side) {
    std::fill(along.begin(), along.end(), base);
    for (std::size_t i = first; i <= std::min(first + side, rows - 1); ++i) {
      const double* const row = heights + i * columns;
      for (std::size_t j = 0; j < columns; ++j) along[j] = larger(row[j], along[j]);
    }
    for (std::size_t j = 0; j + 1 < columns; j += side) {
      const auto from = along.begin() + static_cast<std::ptrdiff_t>(j);
      out.push_back(*std::max_element(from, from + static_cast<std::ptrdiff_t>(std::min(side, columns - 1 - j) + 1)));
    }
  }
  return out;
}

}  // namespace

HeightCeilings::HeightCeilings(const double* heights, std::size_t rows, std::size_t columns, std::array<double, 2> step,
                               Vec3 corner)
    : corner_(corner) {
  std::size_t side = 1;
  while (cells_over(rows - 1, side) * cells_over(columns - 1, side) > kMostFinest) side *= 2;
  const std::vector<double> highest = highest_over_cells(heights, rows, columns, side, corner.z);
  const double range = *std::max_element(highest.begin(), highest.end()) - corner.z;
  if (range / kUnits > kShortestUnit) unit_ = range / kUnits;
  Cells cells{cells_over(rows - 1, side), cells_over(columns - 1, side), {}};
  for (const double height : highest) cells.value.push_back(counted(height));
  std::array<double, 2> width{static_cast<double>(side) * step[0], static_cast<double>(side) * step[1]};
  keep(cells, width);
  while (cells.rows * cells.columns > 1) {
    cells = cells.halved();
    width = {2 * width[0], 2 * width[1]};
    keep(cells, width);
  }
  values_.push_back(0);
}

// One more than the rounded quotient, for its rounding; the most where it is no number.
std::uint16_t HeightCeilings::counted(double height) const {
  const double units = std::ceil((height - corner_.z) / unit_) + 1;
  return units < kMostUnits ? static_cast<std::uint16_t>(units) : kMostUnits;
}

void HeightCeilings::keep(const Cells& cells, std::array<double, 2> width) {
  const std::size_t tiles = (cells.columns + 7) / 8, first = values_.size();
  levels_.push_back({{static_cast<std::int32_t>(cells.rows), static_cast<std::int32_t>(cells.columns)},
                     width,
                     static_cast<std::int32_t>(tiles),
                     static_cast<std::int32_t>(first)});
  values_.resize(first + (cells.rows + 3) / 4 * tiles * 32);
  for (std::size_t i = 0; i < cells.rows; ++i) {
    for (std::size_t j = 0; j < cells.columns; ++j) values_[first + place(i, j, tiles)] = cells.near(i, j);
  }
}

}  // namespace plannercheck
