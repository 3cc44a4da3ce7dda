// Extreme vertices by direction, in a time that does not depend on the body: for each cell of directions, the vertices
// that may be extreme along one of them.
//
// The cells are squares on the faces of the cube around the origin. A cell leaves out a vertex if another one is surely
// further along all four corners: every direction of the cell is a mixture of the corners, up to rounding. Vertices
// that are extreme along similar directions share a block. A cell lists the blocks with its vertices, some four, for
// scans in floats.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

inline constexpr int kScanLanes = 8;  // the same on every instruction set, so that files are, too

// Eight vertices: their coordinates over the largest one, as floats, since a scan only looks for candidates.
struct ScanBlock {
  std::array<float, kScanLanes> x, y, z;

  void put(std::size_t lane, Vec3 p, double unit) {
    x[lane] = static_cast<float>(p.x / unit);
    y[lane] = static_cast<float>(p.y / unit);
    z[lane] = static_cast<float>(p.z / unit);
  }
};

// A ScanBlock with its vertices; lanes after the last one repeat it. Two cache lines.
struct alignas(64) CellBlock : ScanBlock {
  std::array<std::int32_t, kScanLanes> vertex;
};

// Blocks of a cell that are scanned together; groups of fewer repeat the last one.
inline constexpr std::size_t kGroup = 4;
typedef std::array<std::uint16_t, kGroup> BlockGroup;
inline constexpr std::size_t kMostCellGroups = 16;

// The limit of 16-bit block numbers.
inline constexpr std::size_t kMostCellVertices = kScanLanes << 16;

// Mostly one group holds all blocks of a cell.
struct Cell {
  BlockGroup first;
  std::uint32_t others = 0, count = 0;  // further groups: the first one's index, and how many
};

struct DirectionCells {
  std::int32_t edge = 0;  // cells along an edge of the cube; 0 without cells
  std::vector<Cell> cells;
  std::vector<BlockGroup> groups;  // further ones
  std::vector<CellBlock> blocks;

  bool empty() const { return edge == 0; }
  std::size_t bytes() const {
    return cells.size() * sizeof cells[0] + groups.size() * sizeof groups[0] + blocks.size() * sizeof blocks[0];
  }

  // The cell of a direction, up to an error of kDirectionError in its place on the face; any cell for 0.
  const Cell& cell(Vec3 u) const { return cells[index(u)]; }
  std::size_t index(Vec3 u) const {
    const double x = std::fabs(u.x), y = std::fabs(u.y), z = std::fabs(u.z);
    const double wide = larger(x, y), length = larger(wide, z);
    const double along = blended(z, wide, u.z, blended(y, x, u.y, u.x));
    const double next = blended(z, wide, u.x, blended(y, x, u.z, u.y));
    const double last = blended(z, wide, u.y, blended(y, x, u.x, u.z));
    const auto second = static_cast<std::size_t>(y > x), third = static_cast<std::size_t>(z > wide);
    const std::size_t axis = second + third * (2 - second);
    const std::size_t face = 2 * axis + static_cast<std::size_t>(along < 0);
    const auto count = static_cast<std::size_t>(edge);
    return (face * count + column(next, length)) * count + column(last, length);
  }

  // A quotient of two numbers and its sum with 1 err by 2^-53 each.
  static constexpr double kDirectionError = 2 * 0x1p-53;

 private:
  // One of two numbers, the first if a > b: without a branch, which nothing could foretell.
  static double blended(double a, double b, double first, double second) {
    typedef double Two __attribute__((vector_size(16)));
    return (Two{a, a} > Two{b, b} ? Two{first, first} : Two{second, second})[0];
  }

  // The column of an entry between −length and length; NaN counts as −length.
  std::size_t column(double entry, double length) const {
    if (edge == 4) {
      return static_cast<std::size_t>(2 * entry > -length) + static_cast<std::size_t>(entry > 0) +
             static_cast<std::size_t>(2 * entry > length);
    }
    const double place = entry / length;
    const double last = edge - 1, within = (place + 1) * (0.5 * edge);
    const double from_0 = within > 0 ? within : 0;
    return static_cast<std::size_t>(static_cast<std::int32_t>(from_0 < last ? from_0 : last));
  }
};

// Empty for bodies with more vertices that may be extreme along similar directions than a descent scans.
DirectionCells direction_cells(const std::vector<Vec3>& points, double largest_coordinate);

}  // namespace plannercheck
