#include "narrow_phase/tree_frames.hpp"

#include <cmath>

namespace plannercheck {
namespace {

// The error of a number that is rounded to a float, as a part of it.
constexpr double kRoundedToFloat = 0x1p-24;

// Directions are longer than 1 by less than this, an error in each coordinate is √3 at most, and bounds are rounded.
constexpr double kErrorLength = 1.7321 * (1 + 0x1p-12);

// Denormal floats lose what their bound does not count.
constexpr float kFloatDenormals = 1e-37F;

// A way as short as that has no direction.
constexpr float kLeastFloatWay = 1e-12F;

Floats gap_along_way(const Meeting& m, const BoxAbroad& other) {
  const Floats square = dot(m.way, m.way);
  Floats length;
  for (int k = 0; k < kFloats; ++k) length[k] = std::sqrt(square[k]);
  const FloatMask is_way = length > kLeastFloatWay;
  const Floats inverse = 1.0F / (is_way ? length : Floats{} + 1.0F);
  const AxisFloats direction{m.way[0] * inverse, m.way[1] * inverse, m.way[2] * inverse};
  Floats gap = dot(m.way, direction);
  for (std::size_t j = 0; j < 3; ++j) {
    gap -= m.boxes.half[j] * absolute(dot(m.boxes.axis[j], direction));
    gap -= other.half[j] * absolute(dot(direction, other.axis[j]));
  }
  return is_way ? gap : Floats{} - __builtin_inff();
}

}  // namespace

TreeMap::TreeMap(const PosedSolid& from, const PosedSolid& to, const RelativePose& relative, double reach) {
  const TriangleTree &source = from.solid->tree, &target = to.solid->tree;
  const double scale = target.units / source.units;
  const Vec3 middle = relative.apply(source.middle) - target.middle;
  scale_ = static_cast<float>(scale);
  double most = 0;
  turn_ = {}, place_ = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double entry = relative.pose().m[4 * i + j];
      place_[j][i] = scale * entry, turn_[j][i] = static_cast<float>(entry);
    }
    const double shift = target.units * middle[i];
    place_[3][i] = shift;
    most += std::fabs(shift);
  }
  // The middle of the other tree is taken off, which is within its reach. A mapped centre is rounded to floats.
  const double posing = relative.error(norm_1(from.solid->reach) + norm_1(to.solid->reach)) * kErrorLength +
                        reach * kFrameStretch * (1 + 0x1p-12);
  room_ = static_cast<float>(target.units * posing + 2 * kRoundedToFloat * (most + 4 * scale)) * (1 + kFloatSums) +
          kFloatDenormals;
}

void TreeMap::put_abroad(const OrientedBox& box, BoxAbroad& out) const {
  const auto written = [](BoxAbroad::Vector& to, FourFloats from) { std::memcpy(to.data(), &from, sizeof from); };
  const auto& c = box.centre;
  const FourDoubles place = (place_[0] * static_cast<double>(c[0]) + place_[1] * static_cast<double>(c[1])) +
                            (place_[2] * static_cast<double>(c[2]) + place_[3]);
  written(out.centre, __builtin_convertvector(place, FourFloats));
  float sum = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    const auto& axis = box.axis[j];
    written(out.axis[j], (turn_[0] * axis[0] + turn_[1] * axis[1]) + turn_[2] * axis[2]);
    out.half[j] = box.half[j] * scale_;
    sum += out.half[j];
  }
  out.room = room_ + sum * kLaneError;
}

Floats children_gaps(const TriangleNode& node, const BoxAbroad& other) {
  const Meeting m = meeting(node, other);
  return larger(gap_along_axes(m, other), gap_along_way(m, other)) - m.room;
}

}  // namespace plannercheck
