#include "bodies/oriented_box.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace plannercheck {
namespace {

// The error of coordinates up to 1 along axes, in doubles: differences and powers of two err by 2^-50 where points are
// taken to the units, the axes' inverse by less than 32u, and products and sums with it by 16u.
constexpr double kFitError = 0x1p-46;

// Own axes have to make a box so much smaller: else the frame's do as well.
constexpr double kWorthwhile = 0.98;

// Jacobi's method: far more turns than three axes take, and when to stop, far below what 16 bits show.
constexpr int kMostTurns = 24;
constexpr double kTurned = 0x1p-50;

// Directions at right angles up to this are taken as such; a triangle that is hardly one has no normal.
constexpr double kAcross = 0x1p-30;

constexpr ShortAxes kFrameAxes{{{32767, 0, 0}, {0, 32767, 0}}};

float float_above(double value) {
  const auto rounded = static_cast<float>(value);
  return static_cast<double>(rounded) < value ? std::nextafterf(rounded, std::numeric_limits<float>::infinity())
                                              : rounded;
}

Vec3 in_doubles(const std::array<float, 3>& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

std::array<std::int16_t, 3> in_shorts(Vec3 u) {
  const auto entry = [](double value) { return static_cast<std::int16_t>(std::lround(value * 32767)); };
  return {entry(u.x), entry(u.y), entry(u.z)};
}

struct Interval {
  double low = std::numeric_limits<double>::infinity(), high = -low;
};

// The extent of points along a row.
Interval along(const PointColumns& points, Vec3 row) {
  Interval out;
  for (std::size_t k = 0; k < points.count; ++k) {
    const double value = row.x * points.x[k] + row.y * points.y[k] + row.z * points.z[k];
    out.low = smaller(out.low, value), out.high = larger(out.high, value);
  }
  return out;
}

FittedBox fitted(const PointColumns& points, const ShortAxes& axes) {
  FittedBox out{axes, {}};
  out.box.axis = unpacked(axes);
  const Vec3 u = in_doubles(out.box.axis[0]), v = in_doubles(out.box.axis[1]), w = in_doubles(out.box.axis[2]);
  const Vec3 across = cross(v, w);
  const double scale = 1 / dot(u, across);
  const std::array<Vec3, 3> rows{scale * across, scale * cross(w, u), scale * cross(u, v)};
  std::array<Interval, 3> extents;
  Vec3 centre;
  for (std::size_t j = 0; j < 3; ++j) {
    extents[j] = along(points, rows[j]);
    centre = centre + (0.5 * (extents[j].low + extents[j].high)) * (j == 0 ? u : j == 1 ? v : w);
  }
  out.box.centre = {static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z)};
  const Vec3 rounded = in_doubles(out.box.centre);
  for (std::size_t j = 0; j < 3; ++j) {
    const double middle = dot(rows[j], rounded);
    out.box.half[j] = float_above(larger(extents[j].high - middle, middle - extents[j].low) + kFitError);
  }
  return out;
}

// Half of a half of the box's surface.
double surface(const OrientedBox& box) {
  const Vec3 h = in_doubles(box.half);
  return h.x * h.y + h.y * h.z + h.z * h.x;
}

FittedBox better_of_frame_and(const PointColumns& points, const ShortAxes& axes) {
  const FittedBox plain = box_along_frame(points), own = fitted(points, axes);
  return surface(own.box) < kWorthwhile * surface(plain.box) ? own : plain;
}

// A direction at right angles to a unit vector.
Vec3 any_across(Vec3 u) {
  const bool is_along_x = std::fabs(u.x) > 0.6;
  return unit(cross(u, is_along_x ? Vec3{0, 1, 0} : Vec3{1, 0, 0}));
}

// Two principal axes of a symmetric matrix (as SurfaceMoments), those with the largest values (Jacobi's method).
ShortAxes principal_axes(const std::array<double, 6>& form) {
  std::array<std::array<double, 3>, 3> a{
      {{form[0], form[5], form[4]}, {form[5], form[1], form[3]}, {form[4], form[3], form[2]}}};
  std::array<std::array<double, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // rows
  for (int turn = 0; turn < kMostTurns; ++turn) {
    std::size_t p = 0, q = 1;
    if (std::fabs(a[0][2]) > std::fabs(a[p][q])) p = 0, q = 2;
    if (std::fabs(a[1][2]) > std::fabs(a[p][q])) p = 1, q = 2;
    if (!(std::fabs(a[p][q]) > kTurned * (std::fabs(a[p][p]) + std::fabs(a[q][q])))) break;
    const double slope = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const double t = (slope >= 0 ? 1 : -1) / (std::fabs(slope) + std::sqrt(slope * slope + 1));
    const double c = 1 / std::sqrt(t * t + 1), s = t * c;
    for (std::size_t k = 0; k < 3; ++k) {
      const double kp = a[k][p], kq = a[k][q];
      a[k][p] = c * kp - s * kq, a[k][q] = s * kp + c * kq;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double pk = a[p][k], qk = a[q][k], up = axes[p][k], uq = axes[q][k];
      a[p][k] = c * pk - s * qk, a[q][k] = s * pk + c * qk;
      axes[p][k] = c * up - s * uq, axes[q][k] = s * up + c * uq;
    }
  }
  std::array<std::size_t, 3> order{0, 1, 2};
  const auto put = [&](std::size_t i, std::size_t j) {
    if (a[order[i]][order[i]] < a[order[j]][order[j]]) std::swap(order[i], order[j]);
  };
  put(0, 1), put(1, 2), put(0, 1);
  const auto row = [&](std::size_t k) { return Vec3{axes[order[k]][0], axes[order[k]][1], axes[order[k]][2]}; };
  return {in_shorts(row(0)), in_shorts(row(1))};
}

}  // namespace

FittedBox box_along_frame(const PointColumns& points) { return fitted(points, kFrameAxes); }

AlignedBox around(const OrientedBox& box) {
  AlignedBox out{box.centre, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) out.half[i] += std::fabs(box.axis[j][i]) * box.half[j];
    out.half[i] *= kAroundRoundedUp;
  }
  return out;
}

void SurfaceMoments::add(const SurfaceMoments& other) {
  area += other.area;
  first = first + other.first;
  for (std::size_t k = 0; k < second.size(); ++k) second[k] += other.second[k];
}

// The moments of a triangle with the middle m: area / 12 (9 m mᵀ + a aᵀ + b bᵀ + c cᵀ).
SurfaceMoments moments_of(Vec3 a, Vec3 b, Vec3 c) {
  SurfaceMoments out;
  out.area = 0.5 * norm(cross(b - a, c - a));
  const Vec3 sum = a + b + c;
  out.first = (out.area / 3) * sum;
  const double part = out.area / 12;
  const auto product = [&](int i, int j) { return part * (sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]); };
  out.second = {product(0, 0), product(1, 1), product(2, 2), product(1, 2), product(2, 0), product(0, 1)};
  return out;
}

FittedBox fitted_box(const PointColumns& points, const SurfaceMoments& moments) {
  if (!(moments.area > 0)) return box_along_frame(points);
  const Vec3 m = (1 / moments.area) * moments.first;
  const std::array<double, 6> of_middle{m.x * m.x, m.y * m.y, m.z * m.z, m.y * m.z, m.z * m.x, m.x * m.y};
  std::array<double, 6> spread;
  for (std::size_t k = 0; k < 6; ++k) spread[k] = moments.second[k] / moments.area - of_middle[k];
  return better_of_frame_and(points, principal_axes(spread));
}

FittedBox fitted_box_of_triangle(const PointColumns& points) {
  const auto corner = [&](std::size_t k) { return Vec3{points.x[k], points.y[k], points.z[k]}; };
  const std::array<Vec3, 3> edges{corner(1) - corner(0), corner(2) - corner(1), corner(0) - corner(2)};
  Vec3 longest = edges[0];
  for (const Vec3& edge : edges) {
    if (dot(edge, edge) > dot(longest, longest)) longest = edge;
  }
  if (norm_1(longest) == 0) return box_along_frame(points);
  const Vec3 u = unit(longest);
  const Vec3 across = cross(cross(edges[0], edges[1]), u);
  const bool has_normal = norm_1(across) > 0 && std::fabs(dot(unit(across), u)) < kAcross;
  const Vec3 v = has_normal ? unit(across) : any_across(u);
  return better_of_frame_and(points, {in_shorts(u), in_shorts(v)});
}

}  // namespace plannercheck
