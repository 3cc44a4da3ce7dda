#include "direction_cells.hpp"

#include <algorithm>
#include <numeric>

#include "spatial_parts.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kFaces = 6;
constexpr std::size_t kEdge = DirectionCells::kEdge;
// A height is three products with entries of at most 1 and two sums: two of them, and their difference, err by less
// than 32u of the largest coordinate.
constexpr double kHeightError = 32 * 0x1p-53, kSmallestHeight = 1e-300;

typedef std::vector<std::int32_t> Vertices;

// A square of a face, of which there are `edge` by `edge`.
struct Square {
  std::size_t face;
  std::int32_t row, column, edge;

  Vec3 direction(double s, double t) const {
    std::array<double, 3> entry{};
    entry[face / 2] = face % 2 == 0 ? 1 : -1;
    entry[(face / 2 + 1) % 3] = s;
    entry[(face / 2 + 2) % 3] = t;
    return {entry[0], entry[1], entry[2]};
  }

  std::array<Vec3, 4> corners() const {
    const double size = 2.0 / edge;
    const double s0 = row * size - 1, s1 = (row + 1) * size - 1;
    const double t0 = column * size - 1, t1 = (column + 1) * size - 1;
    return {direction(s0, t0), direction(s0, t1), direction(s1, t0), direction(s1, t1)};
  }

  std::array<Square, 4> quarters() const {
    const std::int32_t r = 2 * row, c = 2 * column, e = 2 * edge;
    return {{{face, r, c, e}, {face, r, c + 1, e}, {face, r + 1, c, e}, {face, r + 1, c + 1, e}}};
  }
};

// The vertices that may be extreme along the directions of each cell.
class CellLists {
  static constexpr std::size_t kDirections = 5;  // a square's corners, and about its middle
  typedef std::array<double, kDirections> Heights;

 public:
  CellLists(const std::vector<Vec3>& points, double largest_coordinate)
      : points_(points),
        doubt_(kHeightError * largest_coordinate + kSmallestHeight),
        lists_(DirectionCells::kCells),
        towards_(points.size()) {
    Vertices all(points.size());
    std::iota(all.begin(), all.end(), 0);
    for (std::size_t face = 0; face < kFaces; ++face) divide({face, 0, 0, 1}, all);
  }

  const std::vector<Vertices>& lists() const { return lists_; }
  // Per vertex: about the middle of the directions along which it is extreme, of any length.
  const std::vector<Vec3>& towards() const { return towards_; }

 private:
  const std::vector<Vec3>& points_;
  const double doubt_;  // what heights differ by, at least, to differ surely
  std::vector<Vertices> lists_;
  std::vector<Vec3> towards_;
  std::vector<Heights> heights_, leaders_;  // of the square at hand

  void divide(const Square& square, const Vertices& candidates) {
    const Vertices left = remaining(square, candidates);
    if (at(square.edge) == kEdge) return add(square, left);
    for (const Square& quarter : square.quarters()) divide(quarter, left);
  }

  void add(const Square& cell, const Vertices& vertices) {
    lists_[(cell.face * kEdge + at(cell.row)) * kEdge + at(cell.column)] = vertices;
    const std::array<Vec3, 4> corners = cell.corners();
    const Vec3 middle = corners[0] + corners[3];
    for (const std::int32_t v : vertices) towards_[at(v)] = towards_[at(v)] + 1 / norm(middle) * middle;
  }

  Vertices remaining(const Square& square, const Vertices& candidates) {
    measure(square, candidates);
    Vertices left;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const auto outdoes = [&](const Heights& leader) { return is_further(leader, heights_[i]); };
      if (std::none_of(leaders_.begin(), leaders_.end(), outdoes)) left.push_back(candidates[i]);
    }
    return left;
  }

  // The candidates' heights, and those of the ones that are highest along a corner or the middle.
  void measure(const Square& square, const Vertices& candidates) {
    const std::array<Vec3, 4> corners = square.corners();
    heights_.resize(candidates.size());
    std::array<std::size_t, kDirections> highest{};
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Vec3 p = points_[at(candidates[i])];
      Heights& h = heights_[i];
      for (std::size_t k = 0; k < corners.size(); ++k) h[k] = dot(corners[k], p);
      h.back() = (h[0] + h[1]) + (h[2] + h[3]);
      for (std::size_t k = 0; k < kDirections; ++k) highest[k] = h[k] > heights_[highest[k]][k] ? i : highest[k];
    }
    std::sort(highest.begin(), highest.end());
    leaders_.clear();
    const auto* const end = std::unique(highest.begin(), highest.end());
    for (const auto* i = highest.begin(); i != end; ++i) leaders_.push_back(heights_[*i]);
  }

  bool is_further(const Heights& a, const Heights& b) const {
    bool further = true;
    for (std::size_t k = 0; k < 4; ++k) further &= a[k] - b[k] > doubt_;
    return further;
  }
};

void lay_out_blocks(const std::vector<Vec3>& points, std::vector<Vec3> towards, double unit, DirectionCells& cells) {
  for (Vec3& direction : towards) direction = 1 / larger(norm(direction), 1e-9) * direction;
  Vertices order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const std::vector<IndexRange> parts = spatial_parts(towards, {order.data(), order.data() + order.size()}, kScanLanes);
  for (const IndexRange part : parts) {
    std::sort(part.first, part.last);
    CellBlock& block = cells.blocks.emplace_back();
    for (std::size_t lane = 0; lane < kScanLanes; ++lane) {
      const std::int32_t v = part.first[std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(lane), part.size() - 1)];
      block.put(lane, points[at(v)], unit);
      block.vertex[lane] = v;
    }
  }
}

}  // namespace

DirectionCells direction_cells(const std::vector<Vec3>& points, double largest_coordinate) {
  DirectionCells cells;
  const CellLists lists(points, largest_coordinate);
  lay_out_blocks(points, lists.towards(), largest_coordinate > 0 ? largest_coordinate : 1, cells);
  std::vector<std::size_t> block_of(points.size());
  for (std::size_t b = 0; b < cells.blocks.size(); ++b) {
    for (const std::int32_t v : cells.blocks[b].vertex) block_of[at(v)] = b;
  }
  for (const Vertices& list : lists.lists()) {
    std::uint64_t blocks = 0;
    for (const std::int32_t v : list) blocks |= std::uint64_t{1} << block_of[at(v)];
    cells.cells.push_back(blocks);
  }
  return cells;
}

}  // namespace plannercheck
