// The arrays that cross into Python, and conversions of them to poses and pairs of indices.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "math/vec.hpp"

namespace plannercheck {

template <class Number, int... sizes>
using InputArray =
    nanobind::ndarray<const Number, nanobind::shape<sizes...>, nanobind::c_contig, nanobind::device::cpu>;

// From the first three rows of a row-major 4x4 matrix.
inline Pose pose_from(const double* matrix) {
  Pose pose;
  std::memcpy(pose.m.data(), matrix, sizeof pose.m);
  return pose;
}

using PoseRows = InputArray<double, -1, 4, 4>;

// One of several poses, or the only one.
inline Pose pose_at(const PoseRows& poses, std::size_t i) {
  return pose_from(poses.data() + (poses.shape(0) == 1 ? 0 : 16 * i));
}

inline std::vector<std::array<std::int32_t, 2>> pairs_from(InputArray<std::int32_t, -1, 2> pairs) {
  std::vector<std::array<std::int32_t, 2>> out(pairs.shape(0));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {pairs(i, 0), pairs(i, 1)};
  return out;
}

inline std::vector<Vec3> points_from(InputArray<double, -1, 3> rows) {
  std::vector<Vec3> out(rows.shape(0));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {rows(i, 0), rows(i, 1), rows(i, 2)};
  return out;
}

// Corners of triangles.
inline std::vector<std::array<std::int32_t, 3>> triples_from(InputArray<std::int32_t, -1, 3> rows) {
  std::vector<std::array<std::int32_t, 3>> out(rows.shape(0));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {rows(i, 0), rows(i, 1), rows(i, 2)};
  return out;
}

// A new NumPy array that owns a copy of the values.
template <class Number>
auto output_array(const std::vector<Number>& values, std::initializer_list<std::size_t> shape) {
  auto data = std::make_unique<Number[]>(std::max<std::size_t>(values.size(), 1));
  std::copy(values.begin(), values.end(), data.get());
  Number* raw = data.release();
  nanobind::capsule owner(raw, [](void* p) noexcept { delete[] static_cast<Number*>(p); });
  return nanobind::ndarray<nanobind::numpy, Number>(raw, shape, owner);
}

// Points as rows of three numbers.
inline void append(std::vector<double>& rows, Vec3 p) { rows.insert(rows.end(), {p.x, p.y, p.z}); }
inline auto point_array(Vec3 p) { return output_array(std::vector<double>{p.x, p.y, p.z}, {std::size_t{3}}); }
inline auto point_array(const std::vector<Vec3>& points) {
  std::vector<double> rows;
  rows.reserve(3 * points.size());
  for (const Vec3& p : points) append(rows, p);
  return output_array(rows, {points.size(), std::size_t{3}});
}

// Counters by their names.
template <class Counters>
nanobind::dict named_counters(
    const Counters& counters,
    std::initializer_list<std::pair<const char*, long std::type_identity_t<Counters>::*>> members) {
  nanobind::dict out;
  for (const auto& [name, member] : members) out[name] = counters.*member;
  return out;
}

}  // namespace plannercheck
