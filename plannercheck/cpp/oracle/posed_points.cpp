#include "oracle/posed_points.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace plannercheck::oracle {
namespace {

// The direction's entries are cut to 53 bits. A rounded product of three terms with it errs by at most 6 · 2^-53 of the
// sum of |g_k v_k|, in any order of summation; 8 leaves room for computing that sum in doubles.
constexpr double kProductError = 8 * 0x1p-53;
// Products below 2^-1022 lose bits; all factors are at most 1.
constexpr double kLostToUnderflow = 0x1p-1000;

Integer whole(const Binary& number, int unit) {
  return number.mantissa == 0 ? Integer() : Integer(number.mantissa, static_cast<std::size_t>(number.exponent - unit));
}

Integer whole_product(const Binary& a, const Binary& b, int unit) {
  if (a.mantissa == 0 || b.mantissa == 0) return {};
  return Integer(static_cast<__int128>(a.mantissa) * b.mantissa,
                 static_cast<std::size_t>(a.exponent + b.exponent - unit));
}

}  // namespace

Binary::Binary(double value) {
  if (value == 0) return;
  const double fraction = std::frexp(value, &exponent);
  mantissa = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  mantissa /= std::int64_t{1} << zeros;
  exponent += zeros - 53;
}

int common_unit(const Binary* numbers, std::size_t count) {
  int unit = kNoUnit;
  for (std::size_t i = 0; i < count; ++i) {
    if (numbers[i].mantissa != 0) unit = std::min(unit, numbers[i].exponent);
  }
  return unit;
}

Points::Points(const double* given, std::size_t count, double radius) : inflation_radius(radius) {
  double size = 0;
  for (std::size_t i = 0; i < 3 * count; ++i) size = std::max(size, std::fabs(given[i]));
  const int scale = size > 0 ? std::ilogb(size) + 1 : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double* v = given + 3 * i;
    vertices.push_back({Binary(v[0]), Binary(v[1]), Binary(v[2])});
    unit = std::min(unit, common_unit(vertices.back().data(), 3));
    for (std::size_t k = 0; k < 3; ++k) {
      scaled[k].push_back(std::ldexp(v[k], -scale));
      largest[k] = std::max(largest[k], std::fabs(scaled[k].back()));
    }
  }
}

PosedPoints::PosedPoints(const Points& points, const double* pose) : points_(points) {
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t k = 0; k < 3; ++k) matrix_[3 * row + k] = Binary(pose[4 * row + k]);
    shift_[row] = Binary(pose[4 * row + 3]);
  }
  matrix_unit_ = common_unit(matrix_.data(), 9);
  unit_ =
      std::min({points.unit + matrix_unit_, common_unit(shift_.data(), 3), common_unit(&points.inflation_radius, 1)});
}

Vector PosedPoints::point(std::size_t vertex) const {
  const std::array<Binary, 3>& v = points_.vertices[vertex];
  const auto row = [&](std::size_t i) {
    Integer sum = whole(shift_[i], unit_);
    for (std::size_t k = 0; k < 3; ++k) sum = sum + whole_product(matrix_[3 * i + k], v[k], unit_);
    return sum;
  };
  return {row(0), row(1), row(2)};
}

Integer PosedPoints::inflation_radius() const { return whole(points_.inflation_radius, unit_); }

// Mᵀ d in units of the matrix's entries: a vector of any length.
Vector PosedPoints::pulled_back(const Vector& d) const {
  const auto column = [&](std::size_t k) {
    return (whole(matrix_[k], matrix_unit_) * d.x + whole(matrix_[k + 3], matrix_unit_) * d.y) +
           whole(matrix_[k + 6], matrix_unit_) * d.z;
  };
  return {column(0), column(1), column(2)};
}

std::size_t PosedPoints::lowest(const Vector& direction, bool every) const {
  const Vector g = pulled_back(direction);
  const auto bits = static_cast<std::int64_t>(std::max({g.x.bits(), g.y.bits(), g.z.bits()}));
  const double x = g.x.over_power_of_two(bits), y = g.y.over_power_of_two(bits), z = g.z.over_power_of_two(bits);
  std::vector<double> products(count());
  for (std::size_t i = 0; i < count(); ++i)
    products[i] = (x * points_.scaled[0][i] + y * points_.scaled[1][i]) + z * points_.scaled[2][i];
  const double sizes =
      std::fabs(x) * points_.largest[0] + std::fabs(y) * points_.largest[1] + std::fabs(z) * points_.largest[2];
  const double tie =
      *std::min_element(products.begin(), products.end()) + 2 * (kProductError * sizes + kLostToUnderflow);
  const auto exactly = [&](std::size_t i) {
    const std::array<Binary, 3>& v = points_.vertices[i];
    return (whole(v[0], points_.unit) * g.x + whole(v[1], points_.unit) * g.y) + whole(v[2], points_.unit) * g.z;
  };
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < count(); ++i) {
    if (every || products[i] <= tie) candidates.push_back(i);
  }
  if (candidates.size() == 1) return candidates[0];
  std::size_t best = candidates[0];
  Integer least = exactly(best);
  for (const std::size_t i : candidates) {
    Integer found = exactly(i);
    if (found < least) best = i, least = std::move(found);
  }
  return best;
}

}  // namespace plannercheck::oracle
