// Boxes of two solids' trees at the solids' poses: which children of a node may meet a box of the other tree, in lanes.
//
// In: two posed solids and their inflation radii. Out: for each direction an affine map between the trees' units, with
// a bound of its rounding, and boxes that it maps. Fifteen directions are tried: the axes of both boxes, and the cross
// products of two axes. Infinities and NaN count as meeting.
//
// Why that is right: a point c + Σ t_j u_j of a child, |t_j| ≤ h_j, that is a point b + Σ s_i v_i + e of the other box,
// |s_i| ≤ g_i, has d · (b − c) = Σ t_j d · u_j − Σ s_i d · v_i − d · e for each direction d, so that |d · (b − c)| is
// at most Σ h_j |d · u_j| + Σ g_i |d · v_i| + |d| |e|. For d = u_k the first sum is h_k up to kAxisError times all h_j;
// for d = v_k the second likewise.
#pragma once

#include <array>

#include "bodies/lane_boxes.hpp"
#include "bodies/solid.hpp"
#include "math/simd.hpp"
#include "narrow_phase/posed_solid.hpp"

namespace plannercheck {

// A box of one tree in the other one's units. Vectors have a fourth entry, so that they are written at once.
struct BoxAbroad {
  typedef std::array<float, 4> Vector;

  Vector centre;
  std::array<Vector, 3> axis;
  std::array<float, 3> half;
  float room;  // how far points of the box may be from where it is: all errors but those of lanes
};

// From one tree's units to the other's.
class TreeMap {
 public:
  // `reach`: how far from their triangles points of both solids together may be, in the world.
  TreeMap(const PosedSolid& from, const PosedSolid& to, const RelativePose& relative, double reach);

  void put_abroad(const OrientedBox& box, BoxAbroad& out) const;
  float scale() const { return scale_; }  // of lengths

 private:
  typedef float FourFloats __attribute__((vector_size(16)));
  typedef double FourDoubles __attribute__((vector_size(32)));

  std::array<FourFloats, 3> turn_;    // columns
  std::array<FourDoubles, 4> place_;  // columns, and the shift
  float scale_, room_;
};

// The rounding of sums of a few products of floats.
inline constexpr float kFloatSums = 0x1p-20F;

// The error as a part of all half extents and of the way between middles: axes are off orthonormal in their tree
// (kAxisError) and by poses that are not rigid (2^-17); kFloatSums is for products and sums.
inline constexpr float kLaneError = 0x1p-12F;
static_assert(kLaneError >= kAxisError + 0x1p-17F + 4 * kFloatSums);

typedef std::array<Floats, 3> AxisFloats;

[[gnu::always_inline]] inline Floats dot(const AxisFloats& a, const AxisFloats& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
[[gnu::always_inline]] inline Floats dot(const AxisFloats& a, const BoxAbroad::Vector& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

// What is common to all directions.
struct Meeting {
  LaneBoxes boxes;
  AxisFloats way;  // from the children's middles to the box's
  Floats room;     // added to half extents
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
  const AxisFloats& half = m.boxes.half;
  AxisFloats reach = half;  // of both boxes along the children's axes
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

// The largest gap along directions at right angles to an axis of each box, but for the room times kEdgeRoom. With w the
// way, u and v the axes, R = u · v, and j1, j2 those after j: (w · u_j2) R_j1i − (w · u_j1) R_j2i = w · D for D = v_i ×
// d_j and d_j = u_j2 × u_j1, whatever the axes are (Lagrange). So w · D is at most Σ h_k |u_k · D| + Σ g_l |v_l · D| +
// |D| |e|.
// - u_k · D is given by the same formula with u_k for w: for orthonormal axes 0, −R_j2i and R_j1i, from which it is off
//   by √2 ε at most, ε = kAxisError;
// - v_i · D is 0, and v_l · D = d_j · (v_l × v_i), which is ± u_j · v_k with k the third axis, but for two errors: d_j
//   is off −u_j by √2 ε, and v_l × v_i is off ± v_k by 2.1 ε' with ε' = ε + 2^-17 (along both √2 ε', across 1.5 ε').
// In all, √2 ε of all h and 3.7 ε of g; products and sums round by less than 2 kFloatSums of w, h and g. The room has
// 2 ε of each.
inline constexpr float kEdgeRoom = 3;
static_assert(kEdgeRoom * kLaneError >= 1.42F * kAxisError + 2.1F * (kAxisError + 0x1p-17F) + 2 * kFloatSums);

[[gnu::always_inline]] inline Floats gap_along_edges(const Meeting& m, const BoxAbroad& other) {
  std::array<AxisFloats, 3> cosine;  // by their axis
  AxisFloats way;
  for (std::size_t j = 0; j < 3; ++j) {
    way[j] = dot(m.way, m.boxes.axis[j]);
    for (std::size_t i = 0; i < 3; ++i) cosine[i][j] = dot(m.boxes.axis[j], other.axis[i]);
  }
  Floats gap = Floats{} - __builtin_inff();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const Floats along = absolute(way[j2] * cosine[i][j1] - way[j1] * cosine[i][j2]);
      const Floats own = m.boxes.half[j1] * absolute(cosine[i][j2]) + m.boxes.half[j2] * absolute(cosine[i][j1]);
      const Floats theirs = other.half[i1] * absolute(cosine[i2][j]) + other.half[i2] * absolute(cosine[i1][j]);
      gap = larger(gap, along - own - theirs);
    }
  }
  return gap;
}

// Which children may meet, and by how much: the largest gap along a direction, negative for those.
struct NearChildren {
  unsigned bits;
  Floats gap;  // in units of the node's tree
};

// The child with the least gap, of those that may meet; there is one at least.
inline unsigned nearest_of(const NearChildren& near) {
  typedef std::uint32_t Bits __attribute__((vector_size(4 * kFloats)));
  constexpr Bits kLane{1, 2, 4, 8, 16, 32, 64, 128};
  const FloatMask is_near = (kLane & near.bits) != 0;
  const Floats away = is_near ? -near.gap : Floats{} - __builtin_inff();
  const unsigned nearest = bits(away == largest(away)) & near.bits;
  return static_cast<unsigned>(__builtin_ctz(nearest != 0 ? nearest : near.bits));  // gaps may be no numbers
}

// Children of the node that may meet a box in its tree's units.
[[gnu::always_inline]] inline NearChildren children_near(const TriangleNode& node, const BoxAbroad& other) {
  const Meeting m = meeting(node, other);
  const Floats gap = gap_along_axes(m, other) - m.room;
  const unsigned near = ~bits(gap > 0.0F) & node.all();
  if (near == 0) return {near, gap};
  const Floats edge_gap = gap_along_edges(m, other) - kEdgeRoom * m.room;
  return {near & ~bits(edge_gap > 0.0F), gap};
}

// Lower bounds of the children's distances from the box, in units of the node's tree; also along the way between
// middles, so that they are as near as wanted to the distances of boxes that are small beside them.
Floats children_gaps(const TriangleNode& node, const BoxAbroad& other);

}  // namespace plannercheck
