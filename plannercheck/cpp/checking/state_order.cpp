#include "checking/state_order.hpp"

#include <algorithm>
#include <utility>

#include "math/simd.hpp"

namespace plannercheck {
namespace {

// Rows keep their order if they are fewer than kFewRows, or if one in kAlike follows a row of its own cell. From
// kManyRows on, the first kFineColumns numbers are cut more finely; a cell still has a block of rows or more (all
// measured).
constexpr std::size_t kFewRows = 512, kAlike = 8, kManyRows = 8192, kFineColumns = 2;
// Rough quantiles are enough: sorting more rows would take more than a share of few rows.
constexpr std::size_t kSampled = 32;

// The k-th sampled row of n: spread evenly, but not periodic, since the rows themselves may be.
std::size_t sampled_row(std::size_t k, std::size_t n) {
  constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15;
  return static_cast<std::size_t>((k + 1) * kGoldenRatio >> 48U) * n >> 16U;
}

}  // namespace

void StateOrder::find(const double* q, std::size_t n, std::size_t width) {
  is_kept_ = true;
  if (n < kFewRows) return;
  choose_columns(q, n, width);
  if (are_alike_already(q, n, width)) return;
  is_kept_ = false;
  find_route();
  find_cells(q, n, width);
  next_.assign(route_.size(), 0);
  for (std::size_t i = 0; i < n; ++i) ++next_[cells_[i]];
  std::size_t before = 0;
  for (const std::uint16_t cell : route_) before += std::exchange(next_[cell], static_cast<std::uint16_t>(before));
  order_.resize(std::max(order_.size(), n));
  for (std::size_t i = 0; i < n; ++i) order_[next_[cells_[i]]++] = static_cast<std::uint16_t>(i);
}

// The first numbers whose quantiles differ.
void StateOrder::choose_columns(const double* q, std::size_t n, std::size_t width) {
  columns_ = 0;
  for (std::size_t number = 0; number < width && columns_ < kColumns; ++number) {
    std::array<double, kSampled> sample;
    for (std::size_t k = 0; k < kSampled; ++k) sample[k] = q[sampled_row(k, n) * width + number];
    std::sort(sample.begin(), sample.end());
    Column& column = column_[columns_];
    column.number = number;
    column.parts = n >= kManyRows && columns_ < kFineColumns ? kMostParts : kMostParts / 2;
    for (std::size_t k = 1; k < column.parts; ++k) column.cuts[k - 1] = sample[k * kSampled / column.parts];
    if (column.cuts[0] < column.cuts[column.parts - 2]) ++columns_;
  }
}

// Whether enough rows are in their predecessor's cell.
bool StateOrder::are_alike_already(const double* q, std::size_t n, std::size_t width) const {
  const auto share_a_cell = [&](const double* a, const double* b) {
    return std::all_of(column_.begin(), column_.begin() + columns_, [&](const Column& column) {
      const auto part = [&](double value) {
        return std::count_if(column.cuts.begin(), column.cuts.begin() + column.parts - 1,
                             [&](double cut) { return value > cut; });
      };
      return part(a[column.number]) == part(b[column.number]);
    });
  };
  std::size_t alike = 0;
  for (std::size_t k = 0; k < kSampled; ++k) {
    const double* const row = q + sampled_row(k, n - 1) * width;
    alike += share_a_cell(row, row + width) ? 1 : 0;
  }
  return kAlike * alike >= kSampled;
}

// Passes through the parts of a number upwards and downwards by turns, so that each cell differs from the next in one
// number.
void StateOrder::find_route() {
  route_.assign(1, 0);
  for (std::size_t k = 0; k < columns_; ++k) {
    const std::size_t parts = column_[k].parts, before = route_.size();
    route_.resize(before * parts);
    for (std::size_t i = before; i-- > 0;) {
      const std::size_t cell = route_[i] * parts;
      for (std::size_t j = 0; j < parts; ++j) {
        route_[i * parts + j] = static_cast<std::uint16_t>(cell + (i % 2 == 0 ? j : parts - 1 - j));
      }
    }
  }
}

// Rows in lanes: branches would mostly be predicted wrongly.
void StateOrder::find_cells(const double* q, std::size_t n, std::size_t width) {
  cells_.resize(std::max(cells_.size(), n + kLanes));
  for (std::size_t i = 0; i < n; i += kLanes) {
    std::array<const double*, kLanes> row;
    for (std::size_t lane = 0; lane < kLanes; ++lane) row[lane] = q + std::min(i + lane, n - 1) * width;
    LaneMask cells{};
    for (std::size_t k = 0; k < columns_; ++k) {
      const Column& column = column_[k];
      Lanes values{};
      for (std::size_t lane = 0; lane < kLanes; ++lane) values[lane] = row[lane][column.number];
      cells *= static_cast<long long>(column.parts);
      for (std::size_t cut = 0; cut + 1 < column.parts; ++cut) cells -= values > column.cuts[cut];
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) cells_[i + lane] = static_cast<std::uint16_t>(cells[lane]);
  }
}

}  // namespace plannercheck
