// Whether two posed triangles share a point.
//
// In: corners in the world, rounded. Out: the answer where signs of volumes prove it. Idea: two triangles that share a
// point share a point on an edge. So they are apart if no edge of one triangle meets the other, and they meet if an
// edge passes through the inside of the other; signs of volumes of four corners decide both (Guigue and Devillers,
// 2003). Signs that rounding leaves open, e.g. of degenerate and touching triangles, are left to the exact test.
#pragma once

#include <array>

#include "math/vec.hpp"

namespace plannercheck {

using TriangleCorners = std::array<Vec3, 3>;

// Volumes det(b − a, c − a, d − a) of corners whose coordinates err by `error` and whose differences are at most
// `spread` in size: whether their signs can be told, and how large they have to be for that.
bool are_volumes_trusted(double spread, double error);
double volume_bound(double spread, double error);

enum class TriangleAnswer { kApart, kMeet, kOpen };

// `error`: how far each coordinate of the corners may be from the exact one.
TriangleAnswer triangles_meet(const TriangleCorners& a, const TriangleCorners& b, double error);

}  // namespace plannercheck
