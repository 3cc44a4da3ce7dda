// How far the points of a planar body leave the chords of their paths.
//
// In: a chain of links from a frame (the world, or a link) to a body; a piece of a motion. Out: bounds of |p'| and
// |p''| over all points p of the body, seen from the frame, as the parameter goes from 0 to 1 on the piece.
//
// Proof. On a piece all angles are linear, and so is the origin about which the root turns (see PlanarPiece). Seen from
// the frame, p = o + R(φ1) u1 + R(φ2) u2 + … with one constant vector u for each joint, the last one leading to a point
// of the body, and angles φ of constant rates ω. So |p'| <= |o'| + Σ |ω| |u| and, as o'' = 0, |p''| <= Σ ω² |u|.
#pragma once

#include "planar/checker_2d.hpp"

namespace plannercheck {

// A part of a planar motion on which the root turns about a point that moves linearly: for s from 0 to 1 the point is
// at `origin` + s `way`, turned by `heading` + s `turn`; `arm` leads from it to the root and turns with it. A straight
// motion has no arm; an arc has no way, and its arm starts at its centre. Joints move linearly over the motion.
struct PlanarPiece {
  double from, to;  // parameters of the motion
  double origin_x, origin_y, way_x, way_y;
  double heading, turn;
  double arm_x, arm_y;
  double slip;  // bounds how far any point of the robot is from where the piece puts it, m
};
inline constexpr std::size_t kPieceNumbers = sizeof(PlanarPiece) / sizeof(double);

// R(φ) u: the angle's column, and u in the frame that the angle turns.
struct PlanarArm {
  std::int32_t column;
  bool is_root;         // a free root, which a piece's arm shifts
  double x, y, radius;  // u leads to within `radius` of x, y
  double length;        // the largest |u|
};

// The arms from the frame outwards.
struct PlanarChain {
  std::vector<PlanarArm> arms;
};

struct PlanarBound {
  double curvature = 0, speed = 0;  // |p''|; |p'| without the root's way; m
};

// `frame`: a link before that of `body`, or -1 for the world.
PlanarChain planar_chain(const std::vector<PlanarLink>& links, std::int32_t frame, const PlanarGeometryObject& body);

// The last link that carries both.
std::int32_t common_link(const std::vector<PlanarLink>& links, std::int32_t a, std::int32_t b);

// `rates`: by column, of angles, over the piece.
PlanarBound planar_bound(const PlanarChain& chain, const PlanarPiece& piece, const std::vector<double>& rates);

}  // namespace plannercheck
