#include "bodies/direction_cells.hpp"

#include <algorithm>
#include <cstring>

#include "math/box.hpp"
#include "math/interruption.hpp"
#include "math/spatial_partition.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kFaces = 6;
// Points are floats, relative to the middle of all points and divided by the largest distance from it along an axis:
// they err by u = 2^-24. A height is the sum of three entries of at most 1, two of them times exact numbers: it errs by
// 10u, the difference of two heights by 26u. This leaves room for four errors of a direction and for points in doubles.
constexpr float kDoubt = 32 * 0x1p-24F;
static_assert(4 * DirectionCells::kDirectionError < 0x1p-24);

// Cells along an edge of the cube: about three vertices a cell; five for small bodies, which stay in the cache
// (measured).
constexpr std::size_t kSmall = 512;
std::int32_t edge_for(std::size_t vertices) {
  std::int32_t edge = 4;
  while (vertices > kSmall && 16 * at(edge) * at(edge) < vertices) edge *= 2;
  return edge;
}

typedef std::vector<std::int32_t> Vertices;

// Four points at a time: one register on every instruction set.
constexpr std::size_t kFour = 4;
typedef float Four __attribute__((vector_size(kFour * 4)));
typedef std::int32_t FourMask __attribute__((vector_size(kFour * 4)));

// A square of a face that is divided into `edge` by `edge`.
struct Square {
  std::size_t face;
  std::int32_t row, column, edge;

  // From −1 to 1 along both edges of the face, exactly.
  float border(std::int32_t place) const { return 2.0F * static_cast<float>(place) / static_cast<float>(edge) - 1; }

  Vec3 middle() const {
    std::array<double, 3> entry{};
    entry[face / 2] = face % 2 == 0 ? 1 : -1;
    entry[(face / 2 + 1) % 3] = static_cast<double>(border(row) + border(row + 1)) / 2;
    entry[(face / 2 + 2) % 3] = static_cast<double>(border(column) + border(column + 1)) / 2;
    return {entry[0], entry[1], entry[2]};
  }

  std::array<Square, 4> quarters() const {
    const std::int32_t r = 2 * row, c = 2 * column, e = 2 * edge;
    return {{{face, r, c, e}, {face, r, c + 1, e}, {face, r + 1, c, e}, {face, r + 1, c + 1, e}}};
  }
};

// Vertices with their coordinates relative to a face, outwards and along its edges; in fours, the last one repeated.
struct FacePoints {
  std::size_t size = 0;
  Vertices vertex;
  std::vector<float> out, along_rows, along_columns;

  void reserve(std::size_t most) {
    most = (most / kFour + 1) * kFour;
    if (vertex.size() >= most) return;
    vertex.resize(most), out.resize(most), along_rows.resize(most), along_columns.resize(most);
  }

  // Stores at place `size`, and counts it if `counts`.
  void put(std::int32_t v, float o, float r, float c, bool counts) {
    vertex[size] = v, out[size] = o, along_rows[size] = r, along_columns[size] = c;
    size += counts ? 1 : 0;
  }

  void fill_up() {
    while (size % kFour != 0) put(vertex[size - 1], out[size - 1], along_rows[size - 1], along_columns[size - 1], true);
  }
};

Four load(const std::vector<float>& from, std::size_t i) {
  Four four;
  std::memcpy(&four, &from[i], sizeof four);
  return four;
}

constexpr std::size_t kCorners = 4;
typedef std::array<Four, kCorners> Heights;

// The heights of four candidates along the corners of a square.
Heights heights_of(const Square& square, const FacePoints& all, std::size_t i) {
  const Four out = load(all.out, i), r = load(all.along_rows, i), c = load(all.along_columns, i);
  const Four row_0 = out + square.border(square.row) * r, row_1 = out + square.border(square.row + 1) * r;
  const Four column_0 = square.border(square.column) * c, column_1 = square.border(square.column + 1) * c;
  return {row_0 + column_0, row_0 + column_1, row_1 + column_0, row_1 + column_1};
}

// The highest candidate along one direction, lane by lane.
struct Highest {
  Four height = Four{} - __builtin_inff();
  FourMask place{};

  void take(Four other, FourMask at_place) {
    place = other > height ? at_place : place;
    height = other > height ? other : height;
  }

  std::size_t index() const {
    std::size_t lane = 0;
    for (std::size_t k = 1; k < kFour; ++k) lane = height[k] > height[lane] ? k : lane;
    return static_cast<std::size_t>(place[lane]);
  }
};

// The vertices that may be extreme along the directions of each cell.
class CellLists {
 public:
  CellLists(const std::vector<Vec3>& points, std::int32_t edge)
      : edge_(edge), lists_(kFaces * at(edge) * at(edge)), towards_(points.size()) {
    const Box box = box_around(points);
    const Vec3 middle = 0.5 * box.low + 0.5 * box.high;
    double unit = 0;
    for (const Vec3& p : points) unit = larger(unit, norm_max(p - middle));
    if (!(unit > kSmallestUnit)) unit = kSmallestUnit;
    levels_.resize(at(__builtin_ctz(static_cast<unsigned>(edge))) + 2);
    for (std::size_t face = 0; face < kFaces; ++face) {
      take_all(points, middle, unit, face, levels_[0]);
      divide({face, 0, 0, 1}, 0);
    }
  }

  // Whether some cell has more vertices than a descent scans; the lists are then incomplete.
  bool is_too_full() const { return is_too_full_; }

  const std::vector<Vertices>& lists() const { return lists_; }
  // Per vertex: approximately the middle of the directions along which it is extreme, of any length.
  const std::vector<Vec3>& towards() const { return towards_; }

 private:
  static constexpr double kSmallestUnit = 1e-290;  // avoids 0 / 0 where all points coincide

  const std::int32_t edge_;
  bool is_too_full_ = false;
  std::vector<Vertices> lists_;
  std::vector<Vec3> towards_;
  std::vector<FacePoints> levels_;  // of the current squares, from the whole face on

  static void take_all(const std::vector<Vec3>& points, Vec3 middle, double unit, std::size_t face, FacePoints& all) {
    const auto axis = static_cast<int>(face / 2);
    const float sign = face % 2 == 0 ? 1 : -1;
    all.reserve(points.size());
    all.size = 0;
    for (std::size_t v = 0; v < points.size(); ++v) {
      const Vec3 p = points[v] - middle;
      const auto entry = [&](int i) { return static_cast<float>(p[(axis + i) % 3] / unit); };
      all.put(static_cast<std::int32_t>(v), sign * entry(0), entry(1), entry(2), true);
    }
    all.fill_up();
  }

  // `level`: where the square's candidates are.
  void divide(const Square& square, std::size_t level) {
    if (is_too_full_) return;
    poll_interruption();
    keep_remaining(square, levels_[level], levels_[level + 1]);
    if (square.edge == edge_) return add(square, levels_[level + 1]);
    levels_[level + 1].fill_up();
    for (const Square& quarter : square.quarters()) divide(quarter, level + 1);
  }

  void add(const Square& cell, const FacePoints& left) {
    is_too_full_ = left.size > kMostCellGroups * kGroup * kScanLanes;
    if (is_too_full_) return;
    const auto end = left.vertex.begin() + static_cast<std::ptrdiff_t>(left.size);
    lists_[(cell.face * at(edge_) + at(cell.row)) * at(edge_) + at(cell.column)].assign(left.vertex.begin(), end);
    const Vec3 middle = cell.middle();
    const Vec3 direction = 1 / norm(middle) * middle;
    for (std::size_t i = 0; i < left.size; ++i) {
      Vec3& towards = towards_[at(left.vertex[i])];
      towards = towards + direction;
    }
  }

  // Keeps vertices that no leader surely exceeds along all corners. Leaders are highest along a corner or the middle.
  void keep_remaining(const Square& square, const FacePoints& all, FacePoints& left) const {
    const std::array<Heights, kCorners + 1> leaders = leaders_of(square, all);
    left.reserve(all.size);
    left.size = 0;
    std::int32_t last = -1;
    for (std::size_t i = 0; i < all.size; i += kFour) {
      const Heights own = heights_of(square, all, i);
      FourMask outdone{};
      for (const Heights& leader : leaders) {
        FourMask further = leader[0] - own[0] > kDoubt;
        for (std::size_t k = 1; k < kCorners; ++k) further &= leader[k] - own[k] > kDoubt;
        outdone |= further;
      }
      for (std::size_t lane = 0; lane < kFour; ++lane) {
        const std::size_t k = i + lane;
        const bool counts = outdone[lane] == 0 && all.vertex[k] != last;
        last = all.vertex[k];
        left.put(last, all.out[k], all.along_rows[k], all.along_columns[k], counts);
      }
    }
  }

  static std::array<Heights, kCorners + 1> leaders_of(const Square& square, const FacePoints& all) {
    std::array<Highest, kCorners + 1> highest;
    FourMask place{0, 1, 2, 3};
    for (std::size_t i = 0; i < all.size; i += kFour, place += static_cast<std::int32_t>(kFour)) {
      const Heights h = heights_of(square, all, i);
      for (std::size_t k = 0; k < kCorners; ++k) highest[k].take(h[k], place);
      highest[kCorners].take((h[0] + h[1]) + (h[2] + h[3]), place);
    }
    std::array<Heights, kCorners + 1> out;
    for (std::size_t k = 0; k < out.size(); ++k) {
      const std::size_t leader = highest[k].index();
      const Heights h = heights_of(square, all, leader / kFour * kFour);
      for (std::size_t corner = 0; corner < kCorners; ++corner) out[k][corner] = Four{} + h[corner][leader % kFour];
    }
    return out;
  }
};

void lay_out_blocks(const std::vector<Vec3>& points, std::vector<Vec3> towards, double unit, DirectionCells& cells) {
  for (Vec3& direction : towards) direction = 1 / larger(norm(direction), 1e-9) * direction;
  Vertices order = indices_below(points.size());
  const std::vector<IndexRange> parts =
      spatial_partition(towards, {order.data(), order.data() + order.size()}, kScanLanes);
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

// The blocks of the given vertices, in groups.
std::vector<BlockGroup> grouped(const Vertices& vertices, const std::vector<std::uint16_t>& block_of) {
  std::vector<std::uint16_t> blocks;
  blocks.reserve(vertices.size());
  for (const std::int32_t v : vertices) blocks.push_back(block_of[at(v)]);
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  std::vector<BlockGroup> groups((blocks.size() + kGroup - 1) / kGroup);
  for (std::size_t k = 0; k < groups.size() * kGroup; ++k) {
    groups[k / kGroup][k % kGroup] = blocks[std::min(k, blocks.size() - 1)];
  }
  return groups;
}

}  // namespace

DirectionCells direction_cells(const std::vector<Vec3>& points, double largest_coordinate) {
  DirectionCells cells;
  cells.edge = edge_for(points.size());
  const CellLists lists(points, cells.edge);
  if (lists.is_too_full()) return {};
  lay_out_blocks(points, lists.towards(), largest_coordinate > 0 ? largest_coordinate : 1, cells);
  std::vector<std::uint16_t> block_of(points.size());
  for (std::size_t b = 0; b < cells.blocks.size(); ++b) {
    for (const std::int32_t v : cells.blocks[b].vertex) block_of[at(v)] = static_cast<std::uint16_t>(b);
  }
  for (const Vertices& list : lists.lists()) {
    const std::vector<BlockGroup> groups = grouped(list, block_of);
    if (groups.size() > kMostCellGroups) return {};
    const auto others = static_cast<std::uint32_t>(cells.groups.size());
    cells.cells.push_back({groups[0], others, static_cast<std::uint32_t>(groups.size() - 1)});
    cells.groups.insert(cells.groups.end(), groups.begin() + 1, groups.end());
  }
  return cells;
}

}  // namespace plannercheck
