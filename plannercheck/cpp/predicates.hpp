// Signs of polynomials of doubles, exact: a filter in doubles, then double-double, then dyadic numbers.
#pragma once

#include "dyadic.hpp"
#include "vec.hpp"

namespace plannercheck {

inline constexpr double kRoundoff = 0x1p-53;  // u, half the distance of 1 to the next double

// Sign of det(b − a, c − a, d − a): positive if d lies on the side from which a, b, c turn counter-clockwise.
int orientation(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// Sign of u · (a − b): which of two points is further along u.
int compare_along(Vec3 u, Vec3 a, Vec3 b);

// Sign of det(z, (a − v) × (b − v), u): on which side of the plane through z and the normal of the facet v a b u lies.
int wedge_side(Vec3 z, Vec3 v, Vec3 a, Vec3 b, Vec3 u);

// Sign of det(u, a − o, b − o): on which side of the plane through o, a, b the direction u points.
int cone_side(Vec3 u, Vec3 o, Vec3 a, Vec3 b);

// Sign of the component of (b − a) × (c − a) along an axis: the turn a, b, c of the projection along it.
int turn(Vec3 a, Vec3 b, Vec3 c, int axis);

// Whether a, b, c lie on a line.
bool collinear(Vec3 a, Vec3 b, Vec3 c);

}  // namespace plannercheck
