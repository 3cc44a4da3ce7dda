#include "narrow_phase/tree_frames.hpp"

#include <cmath>

#include "bodies/lane_boxes.hpp"

namespace plannercheck {
namespace {

// Of a number that is rounded to a float, and of sums of a few products of such numbers.
constexpr double kRoundedToFloat = 0x1p-24;
constexpr float kFloatSums = 0x1p-20F;

// Of all half extents and the way between middles: what axes are not orthonormal by, in the tree that they come from
// (kAxisError) and by poses that are not rigid (2^-17), and kFloatSums for products and sums.
constexpr float kLaneError = 0x1p-12F;
static_assert(kLaneError >= kAxisError + 0x1p-17F + 4 * kFloatSums);

// Directions are longer than 1 by less than this, an error in each coordinate is √3 at most, and bounds are rounded.
constexpr double kErrorLength = 1.7321 * (1 + 0x1p-12);

// Denormal floats lose what their bound does not count.
constexpr float kFloatDenormals = 1e-37F;

// A way as short as that has no direction.
constexpr float kLeastFloatWay = 1e-12F;

typedef std::array<Floats, 3> FloatVector;

[[gnu::always_inline]] inline Floats dot(const FloatVector& a, const FloatVector& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
[[gnu::always_inline]] inline Floats dot(const FloatVector& a, const BoxAbroad::Vector& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

// What is common to all directions.
struct Meeting {
  LaneBoxes boxes;
  FloatVector way;  // from the children's middles to the box's
  Floats room;      // added to half extents
};

[[gnu::always_inline]] inline Meeting meeting(const TriangleNode& node, const BoxAbroad& other) {
  Meeting out{lane_boxes(node), {}, {}};
  Floats size{};
  for (std::size_t i = 0; i < 3; ++i) {
    out.way[i] = other.centre[i] - out.boxes.centre[i];
    size += absolute(out.way[i]) + out.boxes.half[i];
  }
  out.room = size * kLaneError + other.room;
  return out;
}

// The largest gap along the axes of both boxes, but for the room.
[[gnu::always_inline]] inline Floats gap_along_axes(const Meeting& m, const BoxAbroad& other) {
  const FloatVector& half = m.boxes.half;
  FloatVector reach = half;  // of both boxes along the children's axes
  Floats gap = Floats{} - __builtin_inff();
  for (std::size_t i = 0; i < 3; ++i) {
    Floats theirs = Floats{} + other.half[i];
    for (std::size_t j = 0; j < 3; ++j) {
      const Floats cosine = absolute(dot(m.boxes.axis[j], other.axis[i]));
      theirs += half[j] * cosine, reach[j] += other.half[i] * cosine;
    }
    gap = larger(gap, absolute(dot(m.way, other.axis[i])) - theirs);
  }
  for (std::size_t j = 0; j < 3; ++j) gap = larger(gap, absolute(dot(m.way, m.boxes.axis[j])) - reach[j]);
  return gap;
}

Floats gap_along_way(const Meeting& m, const BoxAbroad& other) {
  const Floats square = dot(m.way, m.way);
  Floats length;
  for (int k = 0; k < kFloats; ++k) length[k] = std::sqrt(square[k]);
  const FloatMask is_way = length > kLeastFloatWay;
  const Floats inverse = 1.0F / (is_way ? length : Floats{} + 1.0F);
  const FloatVector direction{m.way[0] * inverse, m.way[1] * inverse, m.way[2] * inverse};
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
    const double shift = target.units * middle[static_cast<int>(i)];
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

NearChildren children_near(const TriangleNode& node, const BoxAbroad& other) {
  const Meeting m = meeting(node, other);
  const Floats gap = gap_along_axes(m, other) - m.room;
  return {~float_bits(gap > 0.0F) & node.all(), gap};
}

Floats children_gaps(const TriangleNode& node, const BoxAbroad& other) {
  const Meeting m = meeting(node, other);
  return larger(gap_along_axes(m, other), gap_along_way(m, other)) - m.room;
}

}  // namespace plannercheck
