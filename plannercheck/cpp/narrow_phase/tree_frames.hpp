// Boxes of two solids' trees at the solids' poses: which children of a node may meet a box of the other tree, in lanes.
//
// In: two posed solids and how far they reach around their triangles. Out: for each direction an affine map between the
// trees' units, with a bound of all rounding on the way, and boxes that are mapped by it. Six directions are tried, the
// axes of both boxes. Whatever is not finite counts as meeting.
//
// Why that is right: a point c + Σ t_j u_j of a child, |t_j| ≤ h_j, that is a point b + Σ s_i v_i + e of the other box,
// |s_i| ≤ g_i, has d · (b − c) = Σ t_j d · u_j − Σ s_i d · v_i − d · e for each direction d, so that |d · (b − c)| is
// at most Σ h_j |d · u_j| + Σ g_i |d · v_i| + |d| |e|. For d = u_k the first sum is h_k up to kAxisError times all h_j;
// for d = v_k the second likewise.
#pragma once

#include <array>

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
  const unsigned nearest = float_bits(away == largest(away)) & near.bits;
  return static_cast<unsigned>(__builtin_ctz(nearest != 0 ? nearest : near.bits));  // gaps may be no numbers
}

// Children of the node that may meet a box in its tree's units.
NearChildren children_near(const TriangleNode& node, const BoxAbroad& other);

// Lower bounds of the children's distances from the box, in units of the node's tree; also along the way between
// middles, so that they are as near as wanted to the distances of boxes that are small beside them.
Floats children_gaps(const TriangleNode& node, const BoxAbroad& other);

}  // namespace plannercheck
