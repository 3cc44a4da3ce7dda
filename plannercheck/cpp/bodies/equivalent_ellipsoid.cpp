#include "bodies/equivalent_ellipsoid.hpp"

#include <cmath>

namespace plannercheck {
namespace {

typedef std::array<double, 6> Form;

double value(const Form& f, Vec3 u) {
  return f[0] * u.x * u.x + f[1] * u.y * u.y + f[2] * u.z * u.z +
         2 * (f[3] * u.y * u.z + f[4] * u.z * u.x + f[5] * u.x * u.y);
}

Vec3 product(const Form& f, Vec3 u) {
  return {f[0] * u.x + f[5] * u.y + f[4] * u.z, f[5] * u.x + f[1] * u.y + f[3] * u.z,
          f[4] * u.x + f[3] * u.y + f[2] * u.z};
}

// M form Mᵀ
Form turned(const Form& f, const Pose& pose) {
  const auto& m = pose.m;
  const std::array<Vec3, 3> rows{{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}};
  const Vec3 x = product(f, rows[0]), y = product(f, rows[1]), z = product(f, rows[2]);
  return {dot(rows[0], x), dot(rows[1], y), dot(rows[2], z), dot(rows[1], z), dot(rows[2], x), dot(rows[0], y)};
}

// The solution of form u = c, times the positive determinant.
Vec3 solved(const Form& f, Vec3 c) {
  const Vec3 x{f[0], f[5], f[4]}, y{f[5], f[1], f[3]}, z{f[4], f[3], f[2]};
  const Vec3 yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
  return {dot(yz, c), dot(zx, c), dot(xy, c)};
}

constexpr double kRound = 0.1;  // how far, relatively, the form of a nearly round body may differ from a ball's

}  // namespace

// Sums over the tetrahedra of the triangles with a point inside; a solid ellipsoid's moments are a fifth of its form.
EquivalentEllipsoid equivalent_ellipsoid(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  EquivalentEllipsoid out;
  const Vec3 origin = points.empty() ? Vec3{} : points[0];
  double volume = 0;
  Vec3 first;
  Form second{};
  for (const Triangle& t : triangles) {
    const Vec3 a = points[at(t[0])] - origin, b = points[at(t[1])] - origin, c = points[at(t[2])] - origin;
    const double v = dot(a, cross(b, c));
    const Vec3 sum = a + b + c;
    volume += v;
    first = first + v * sum;
    const auto add = [&](std::size_t k, int i, int j) {
      second[k] += v * (a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j]);
    };
    add(0, 0, 0), add(1, 1, 1), add(2, 2, 2), add(3, 1, 2), add(4, 2, 0), add(5, 0, 1);
  }
  const Vec3 m = 1 / (4 * volume) * first;
  out.middle = origin + m;
  const Form outer{m.x * m.x, m.y * m.y, m.z * m.z, m.y * m.z, m.z * m.x, m.x * m.y};
  for (std::size_t k = 0; k < 6; ++k) out.form[k] = 5 * (second[k] / (20 * volume) - outer[k]);
  const Form& f = out.form;
  const double mean = (f[0] + f[1] + f[2]) / 3, x = f[0] - mean, y = f[1] - mean, z = f[2] - mean;
  const double off = std::sqrt(x * x + y * y + z * z + 2 * (f[3] * f[3] + f[4] * f[4] + f[5] * f[5]));
  out.exists = volume > 0 && off < 10 * mean;
  out.is_round = off < kRound * mean;
  return out;
}

// With c the difference of the centres, the best plane's normal u satisfies c ~ (A/|u|_A + B/|u|_B) u. It is solved
// with the lengths |c|_A and |c|_B; another step gains less time than it takes (measured).
Vec3 direction_between(const EquivalentEllipsoid& a, const Pose& pose_a, const EquivalentEllipsoid& b,
                       const Pose& pose_b) {
  const Vec3 c = pose_a.apply(a.middle) - pose_b.apply(b.middle);
  const Form form_a = turned(a.form, pose_a), form_b = turned(b.form, pose_b);
  const double ratio = std::sqrt(value(form_a, c) / value(form_b, c));
  Form sum;
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = form_a[k] + ratio * form_b[k];
  const Vec3 u = solved(sum, c);
  return 1 / norm_max(u) * u;
}

}  // namespace plannercheck
