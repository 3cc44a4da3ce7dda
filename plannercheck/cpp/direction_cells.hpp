// Extreme vertices of middle-sized bodies by direction: which vertices may be extreme along a direction of a cell.
//
// The cells are squares on the faces of the cube around the origin, a direction's is found by comparisons. A vertex
// is left out of a cell if another one is strictly further along all four of its corners: every direction of the cell
// is a mixture of these. Vertices that are extreme along similar directions share a block; a cell is the set of blocks
// that hold what was not left out, some three, which are scanned in floats.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "vec.hpp"

namespace plannercheck {

inline constexpr int kScanLanes = 8;  // the layout is the same on every instruction set, so that files are too

// Eight vertices, as floats of their coordinates over the largest one: a scan looks for candidates only.
struct ScanBlock {
  std::array<float, kScanLanes> x, y, z;

  void put(std::size_t lane, Vec3 p, double unit) {
    x[lane] = static_cast<float>(p.x / unit);
    y[lane] = static_cast<float>(p.y / unit);
    z[lane] = static_cast<float>(p.z / unit);
  }
};

// With the vertices themselves; lanes beyond the last one repeat it. Two cache lines.
struct alignas(64) CellBlock : ScanBlock {
  std::array<std::int32_t, kScanLanes> vertex;
};

struct DirectionCells {
  static constexpr std::size_t kEdge = 4;  // cells along an edge of the cube (measured)
  static constexpr std::size_t kCells = 6 * kEdge * kEdge;

  std::vector<std::uint64_t> cells;  // a bit for each block; empty or kCells of them
  std::vector<CellBlock> blocks;

  bool empty() const { return cells.empty(); }
  std::size_t bytes() const { return cells.size() * sizeof cells[0] + blocks.size() * sizeof blocks[0]; }

  // The cell of a direction, without branches; that of 0 is any.
  static std::size_t cell(Vec3 u) {
    const std::array<double, 5> entry{u.x, u.y, u.z, u.x, u.y};
    const double x = std::fabs(u.x), y = std::fabs(u.y), z = std::fabs(u.z);
    const auto second = static_cast<std::size_t>(y > x), third = static_cast<std::size_t>(z > larger(x, y));
    const std::size_t axis = second + third * (2 - second);
    const std::size_t face = 2 * axis + static_cast<std::size_t>(entry[axis] < 0);
    const double length = larger(larger(x, y), z);
    return (face * kEdge + column(entry[axis + 1], length)) * kEdge + column(entry[axis + 2], length);
  }

 private:
  // Of an entry between −length and length, exactly.
  static std::size_t column(double entry, double length) {
    return static_cast<std::size_t>(2 * entry > -length) + static_cast<std::size_t>(entry > 0) +
           static_cast<std::size_t>(2 * entry > length);
  }
};

// Of at most 64 blocks of vertices.
DirectionCells direction_cells(const std::vector<Vec3>& points, double largest_coordinate);

}  // namespace plannercheck
