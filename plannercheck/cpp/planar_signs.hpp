// Exact signs about two posed polygons in the plane, for the algorithm of planar.cpp.
//
// In: vertices as ordered arrays, poses x -> M x + t with the numbers that their doubles are. Out: signs of polynomials
// of these numbers. Each sign is taken in doubles with a proven bound, where that leaves it open in double-double, and
// where that does, in dyadic numbers. Nothing is prepared and no array is copied.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>

#include "dyadic.hpp"

namespace plannercheck {

// Rows of x, y in the order of the boundary, either way round.
struct PlanarPolygon {
  const double* vertices = nullptr;
  std::size_t count = 0;

  double x(std::size_t k) const { return vertices[2 * k]; }
  double y(std::size_t k) const { return vertices[2 * k + 1]; }
};

// x -> M x + t, row by row: m00 m01 tx m10 m11 ty.
struct PlanarPose {
  std::array<double, 6> m{1, 0, 0, 0, 1, 0};
};

struct PosedPolygon {
  PlanarPolygon shape;
  PlanarPose pose;
};

// The arithmetic that a sign starts with.
enum class Precision { kDoubles, kDoubleDouble, kExact };

struct PlanarCounters {
  long rounds = 0;         // of the algorithm: each prunes one chain or ends
  long vertices = 0;       // read, with repetitions
  long double_double = 0;  // signs that the filter left open
  long exact = 0;          // signs that double-double left open, too
};

struct NotFiniteError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

// A vertex of the guest, seen from the origin of the host's frame along the axes of the world, and the sums of the
// absolute values of the terms of its coordinates.
struct GuestPoint {
  std::size_t index = 0;
  double x = 0, y = 0, size_x = 0, size_y = 0;
};

// The line through two vertices of the host, with its direction.
struct HostLine {
  std::size_t from = 0, to = 0;
  double dx = 0, dy = 0, size_dx = 0, size_dy = 0;  // M (to - from)
  double x = 0, y = 0, size_x = 0, size_y = 0;      // M from
};

// How far a point is on the host's side of a line, times the line's length; infinite error where a filter in doubles
// can't be trusted.
struct Side {
  double value = 0, error = 0;
};

// Non-negative weights of two lines: along the mixed side function a guest is pruned.
struct LineWeights {
  double first = 1, second = 0;
  std::optional<std::array<Dyadic, 2>> exact;  // stands for both where no doubles could be certified
};

class PlanarSigns {
 public:
  // `turn`: 1 if the host's vertices run counter-clockwise, -1 if clockwise.
  PlanarSigns(const PosedPolygon& guest, const PosedPolygon& host, int turn, Precision first, PlanarCounters& counters);

  GuestPoint point(std::size_t index) const;
  HostLine line(std::size_t from, std::size_t to) const;
  Side side(const HostLine& line, const GuestPoint& point) const;

  // Sign of the side of `point`: at least 0 on the host's side.
  int sign(const Side& side, const HostLine& line, const GuestPoint& point) const;
  // Sign of i(a) j(b) - i(b) j(a), of the sides of two points to two lines.
  int mixed(const HostLine& i, const HostLine& j, const GuestPoint& a, const GuestPoint& b) const;
  // Sign of the mixed side function's difference w_i (i(a) - i(b)) + w_j (j(a) - j(b)).
  int compare(const LineWeights& weights, const HostLine& i, const HostLine& j, const GuestPoint& a,
              const GuestPoint& b) const;

  Dyadic exact_side(const HostLine& line, const GuestPoint& point) const;
  const PlanarPolygon& guest() const { return guest_.shape; }

 private:
  const PosedPolygon& guest_;
  const PosedPolygon& host_;
  int turn_;
  Precision first_;
  PlanarCounters& counters_;
  std::array<double, 2> offset_;  // of the guest's origin from the host's, rounded

  double permanent(const HostLine& line, const GuestPoint& point) const;
  void check_finite(const HostLine& line, const GuestPoint& point) const;
};

// Which way round a polygon's vertices run: 1 counter-clockwise, -1 clockwise, 0 if it has no area. A few probes, also
// where many vertices lie on one line: O(log n).
int planar_turn(const PlanarPolygon& polygon, PlanarCounters& counters);

// Whether the segments (or points) between the ends of two polygons without area share a point, exactly.
bool flat_polygons_meet(const PosedPolygon& a, const PosedPolygon& b, PlanarCounters& counters);

}  // namespace plannercheck
