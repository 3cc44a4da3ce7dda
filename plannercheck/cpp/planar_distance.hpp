// The distance of two convex polygons, or of what both sweep between two poses, against a limit.
//
// The same in the plane as swept_distance: Gilbert, Johnson and Keerthi's descent on the hull of the polygons'
// differences at all poses, seen from a frame. Only the lower bound is relied on for "apart": the least product of the
// direction with a difference, over all vertices.
#pragma once

#include <vector>

namespace plannercheck {

struct PlanarVector {
  double x = 0, y = 0;
};

struct PlanarHull {
  std::vector<double> x, y;
};

struct PlanarPlace {
  double cos = 1, sin = 0, x = 0, y = 0;

  PlanarVector turned(PlanarVector v) const { return {cos * v.x - sin * v.y, sin * v.x + cos * v.y}; }
  PlanarVector turned_back(PlanarVector v) const { return {cos * v.x + sin * v.y, cos * v.y - sin * v.x}; }
};

// Both polygons and the frame at one parameter; of the frame only its turn counts.
struct PlanarPlaces {
  PlanarPlace a, b, frame;
};

struct PlanarApart {
  bool apart = false;      // the polygons are more than the limit apart along `direction` at every pose that was given
  PlanarVector direction;  // in the frame, from b to a, of length 1 up to rounding
  double gap = 0;          // along it: a lower bound but for the rounding that the limit has to cover
};

// At `count` poses, 1 or 2, from a direction to begin with.
PlanarApart planar_apart(const PlanarHull& a, const PlanarHull& b, const PlanarPlaces* places, int count, double limit,
                         PlanarVector hint);

// The gap along a direction of the frame at one pose.
double planar_gap(const PlanarHull& a, const PlanarHull& b, const PlanarPlaces& places, PlanarVector direction);

}  // namespace plannercheck
