#include "narrow_phase/tree_frames.hpp"

#include <cmath>

namespace plannercheck {
namespace {

// Coordinates in floats err by this times all that is added up to get them: entries and sums are rounded, at most six
// times one after another, and the bound itself is rounded, too.
constexpr float kFloatSum = 0x1p-20F;

// Denormal floats lose what their bound does not count.
constexpr float kFloatDenormals = 1e-37F;

// Numbers are rounded to floats by at most this part of themselves, and their bounds are computed in as many steps.
constexpr double kRoundedUp = 1 + 0x1p-20;

}  // namespace

TreeMap tree_map(const PosedSolid& from, const PosedSolid& to, const RelativePose& relative, double reach) {
  const TriangleTree &source = from.solid->tree, &target = to.solid->tree;
  const double scale = target.units / source.units;
  const Vec3 middle = relative.apply(source.middle) - target.middle;
  TreeMap map;
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 1;
    for (std::size_t j = 0; j < 3; ++j) {
      const double entry = scale * relative.pose().m[4 * i + j];
      map.m[i][j] = static_cast<float>(entry);
      map.size[i][j] = std::fabs(map.m[i][j]);
      sum += std::fabs(entry);
    }
    const double shift = target.units * middle[static_cast<int>(i)];
    map.shift[i] = static_cast<float>(shift);
    // The middle of the other tree is taken off, which is within its reach.
    const double posing = relative.error(norm_1(from.solid->reach) + norm_1(to.solid->reach)) + reach * kFrameStretch;
    const double doubles = target.units * posing * kRoundedUp;
    map.error[i] = static_cast<float>(doubles) * (1 + kFloatSum) +
                   static_cast<float>(sum + std::fabs(shift)) * kFloatSum + kFloatDenormals;
  }
  return map;
}

FloatBox TreeMap::around(const FloatBox& box) const {
  FloatBox out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.centre[i] = (m[i][0] * box.centre[0] + m[i][1] * box.centre[1]) + (m[i][2] * box.centre[2] + shift[i]);
    out.half[i] = (size[i][0] * box.half[0] + size[i][1] * box.half[1]) + (size[i][2] * box.half[2] + error[i]);
  }
  return out;
}

NearChildren children_near(const TriangleNode& node, const TreeMap& to_other, const FloatBox& box,
                           const FloatBox& image, float scale) {
  const auto centre = [&](std::size_t i) { return load_floats(node.centre[i].data()); };
  const auto half = [&](std::size_t i) { return load_floats(node.half[i].data()); };
  const Floats x = centre(0), y = centre(1), z = centre(2), u = half(0), v = half(1), w = half(2);
  Floats own = absolute(x - image.centre[0]) - (u + image.half[0]);
  own = larger(own, absolute(y - image.centre[1]) - (v + image.half[1]));
  own = larger(own, absolute(z - image.centre[2]) - (w + image.half[2]));
  Floats other = own * scale;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& m = to_other.m[i];
    const auto& s = to_other.size[i];
    const Floats there = (m[0] * x + m[1] * y) + (m[2] * z + to_other.shift[i]);
    const Floats around = (s[0] * u + s[1] * v) + (s[2] * w + (to_other.error[i] + box.half[i]));
    other = larger(other, absolute(there - box.centre[i]) - around);
  }
  return {~(float_bits(own > 0.0F) | float_bits(other > 0.0F)) & ((1U << kTreeWidth) - 1), other};
}

FloatTriangle::FloatTriangle(const TriangleCorners& corners, double error, const TriangleTree& tree, double reach) {
  std::array<Vec3, 3> t;
  double most = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    t[k] = tree.units * (corners[k] - tree.middle);
    most = larger(most, norm_max(t[k]));
  }
  // The place of a point: of its corners, of the difference to the middle, and of floats.
  const double place =
      tree.units * (error + reach * kFrameStretch) * kRoundedUp + (2 + most) * static_cast<double>(kFloatSum);
  const Vec3 across = cross(t[1] - t[0], t[2] - t[0]);
  const double length = norm_1(across);
  const Vec3 normal = length > 0 ? (1 / length) * across : Vec3{};
  double spread = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const int axis = static_cast<int>(i);
    const double low = smaller(t[0][axis], smaller(t[1][axis], t[2][axis]));
    const double high = larger(t[0][axis], larger(t[1][axis], t[2][axis]));
    low_[i] = static_cast<float>(low - place), high_[i] = static_cast<float>(high + place);
    normal_[i] = static_cast<float>(normal[axis]);
    size_[i] = std::fabs(normal_[i]);
  }
  const Vec3 rounded{static_cast<double>(normal_[0]), static_cast<double>(normal_[1]), static_cast<double>(normal_[2])};
  for (const Vec3& corner : t) spread = larger(spread, std::fabs(dot(rounded, corner - t[0])));
  level_ = static_cast<float>(dot(rounded, t[0]));
  room_ = static_cast<float>((spread + place) * kRoundedUp);
}

NearChildren FloatTriangle::children_near(const TriangleNode& node) const {
  Floats gap = Floats{} - __builtin_inff();
  Floats along = Floats{} - level_, around = Floats{} + room_;
  FloatMask apart{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Floats centre = load_floats(node.centre[i].data()), half = load_floats(node.half[i].data());
    const Floats beyond = larger((centre - half) - high_[i], low_[i] - (centre + half));
    apart |= beyond > 0.0F;
    gap = larger(gap, beyond);
    along += normal_[i] * centre, around += size_[i] * half;
  }
  const Floats beyond = absolute(along) - around;
  apart |= beyond > 0.0F;
  return {~float_bits(apart) & ((1U << kTreeWidth) - 1), larger(gap, beyond)};
}

}  // namespace plannercheck
