// Posed vertices as integers: the exact values of the doubles of vertices, pose and inflation radius, in a common unit.
//
// In: points (n, 3), m, an inflation radius, m, a pose (4, 4). Out: posed points and inflation radius in units of
// 2^unit m, and which point is lowest along a direction. Doubles choose the candidates, within a bound of their
// rounding; integers decide.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "oracle/integer.hpp"

namespace plannercheck::oracle {

// mantissa · 2^exponent, exactly; for 0 the exponent has no meaning.
struct Binary {
  std::int64_t mantissa = 0;
  int exponent = 0;

  Binary() = default;
  explicit Binary(double value);
};

// The unit of 0: larger than any double's.
inline constexpr int kNoUnit = 4096;
int common_unit(const Binary* numbers, std::size_t count);

struct Points {
  std::vector<std::array<Binary, 3>> vertices;
  Binary inflation_radius;
  int unit = kNoUnit;  // of all coordinates
  // The coordinates scaled by a power of two to at most 1, column by column, and the largest of each column.
  std::array<std::vector<double>, 3> scaled;
  std::array<double, 3> largest{};

  Points(const double* vertices, std::size_t count, double inflation_radius);
};

class PosedPoints {
 public:
  // `pose`: row-major 4x4.
  PosedPoints(const Points& points, const double* pose);

  int unit() const { return unit_; }
  // `unit` has to be at most the current one.
  void use_unit(int unit) { unit_ = unit; }

  std::size_t count() const { return points_.vertices.size(); }
  // In units of 2^unit m.
  Vector point(std::size_t vertex) const;
  Integer inflation_radius() const;

  // The vertex with the least product with a direction of the world. `every`: compares all by integers alone.
  std::size_t lowest(const Vector& direction, bool every) const;

 private:
  const Points& points_;
  std::array<Binary, 9> matrix_;
  std::array<Binary, 3> shift_;
  int matrix_unit_, unit_;

  Vector pulled_back(const Vector& direction) const;
};

}  // namespace plannercheck::oracle
