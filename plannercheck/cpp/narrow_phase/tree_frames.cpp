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

TreeMap tree_map(const PosedSolid& from, const PosedSolid& to, double reach) {
  const TriangleTree &source = from.solid->tree, &target = to.solid->tree;
  const InversePose inverse(to.pose);
  const double scale = target.units / source.units;
  const Vec3 middle = inverse.apply(from.pose.apply(source.middle)) - target.middle;
  TreeMap map;
  for (std::size_t i = 0; i < 3; ++i) {
    double sum = 1;
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec3 column{from.pose.m[j], from.pose.m[j + 4], from.pose.m[j + 8]};
      const double entry = scale * inverse.rotate(column)[static_cast<int>(i)];
      map.m[i][j] = static_cast<float>(entry);
      map.size[i][j] = std::fabs(map.m[i][j]);
      sum += std::fabs(entry);
    }
    const double shift = target.units * middle[static_cast<int>(i)];
    map.shift[i] = static_cast<float>(shift);
    // The middle of the other tree is taken off, which is within its reach.
    const double posing = inverse.error(posing_magnitude(from) + norm_1(to.solid->reach)) + reach * kFrameStretch;
    const double doubles = target.units * posing * kRoundedUp;
    map.error[i] = static_cast<float>(doubles) * (1 + kFloatSum) +
                   static_cast<float>(sum + std::fabs(shift)) * kFloatSum + kFloatDenormals;
  }
  return map;
}

}  // namespace

FloatBox TreeMap::around(const FloatBox& box) const {
  FloatBox out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.centre[i] = (m[i][0] * box.centre[0] + m[i][1] * box.centre[1]) + (m[i][2] * box.centre[2] + shift[i]);
    out.half[i] = (size[i][0] * box.half[0] + size[i][1] * box.half[1]) + (size[i][2] * box.half[2] + error[i]);
  }
  return out;
}

TreeFrames::TreeFrames(const PosedSolid& a, const PosedSolid& b, double reach)
    : a_to_b_(tree_map(a, b, reach)), b_to_a_(tree_map(b, a, reach)) {}

unsigned children_near(const TriangleNode& node, const TreeMap& to_other, const FloatBox& box, const FloatBox& image) {
  const auto centre = [&](std::size_t i) { return load_floats(node.centre[i].data()); };
  const auto half = [&](std::size_t i) { return load_floats(node.half[i].data()); };
  const Floats x = centre(0), y = centre(1), z = centre(2), u = half(0), v = half(1), w = half(2);
  FloatMask apart = (absolute(x - image.centre[0]) > u + image.half[0]) |
                    (absolute(y - image.centre[1]) > v + image.half[1]) |
                    (absolute(z - image.centre[2]) > w + image.half[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& m = to_other.m[i];
    const auto& s = to_other.size[i];
    const Floats there = (m[0] * x + m[1] * y) + (m[2] * z + to_other.shift[i]);
    const Floats around = (s[0] * u + s[1] * v) + (s[2] * w + (to_other.error[i] + box.half[i]));
    apart |= absolute(there - box.centre[i]) > around;
  }
  return ~float_bits(apart) & ((1U << kTreeWidth) - 1);
}

}  // namespace plannercheck
