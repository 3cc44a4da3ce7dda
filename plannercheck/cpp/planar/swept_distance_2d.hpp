// Whether two convex polygons, or the sets that both sweep between two poses, are further apart than a limit.
//
// The planar form of swept_distance: Gilbert, Johnson and Keerthi's descent on the hull of the polygons' differences at
// all poses, seen from a frame. "Apart" relies only on the lower bound: the least product of the direction with a
// difference, over all vertices.
#pragma once

#include <cmath>
#include <vector>

#include "motions/motion_report.hpp"

namespace plannercheck {

struct PlanarVector {
  double x = 0, y = 0;
};

// A direction. Its length is 1 whatever vector it was made from, so that products with it are in metres.
//
// Rounding of the square, the root and the quotients leaves the length within 8u of 1, u = 2^-53; turning it by a
// link's computed sine and cosine adds as much. A gap of length g along it errs by 16u g, which kPlanarRounding covers.
class PlanarDirection {
 public:
  // The x axis if doubles hold no length of the vector: it is 0, not finite, or beyond any scene.
  static PlanarDirection along(PlanarVector v) {
    const double square = v.x * v.x + v.y * v.y;
    PlanarDirection made;
    if (square >= kLeastSquare && square <= kLargestSquare) {
      const double length = std::sqrt(square);
      made.unit_ = {v.x / length, v.y / length};
    }
    return made;
  }

  PlanarVector vector() const { return unit_; }

 private:
  // In this range squares do not overflow, and what they lose below the least double is irrelevant.
  static constexpr double kLeastSquare = 1e-250, kLargestSquare = 1e250;

  PlanarVector unit_{1, 0};
};

struct PlanarHull {
  std::vector<double> x, y;
};

struct PlanarPlace {
  double cos = 1, sin = 0, x = 0, y = 0;

  PlanarVector turned(PlanarVector v) const { return {cos * v.x - sin * v.y, sin * v.x + cos * v.y}; }
  PlanarVector turned_back(PlanarVector v) const { return {cos * v.x + sin * v.y, cos * v.y - sin * v.x}; }
};

// Both polygons and the frame at one parameter; only the frame's rotation matters.
struct PlanarPlaces {
  PlanarPlace a, b, frame;
};

// `count`: 1 or 2 poses; the descent starts from `hint`.
SweptAnswer<PlanarDirection> planar_apart(const PlanarHull& a, const PlanarHull& b, const PlanarPlaces* places,
                                          int count, double limit, PlanarDirection hint);

// The gap along a direction of the frame at one pose.
double planar_gap(const PlanarHull& a, const PlanarHull& b, const PlanarPlaces& places, PlanarDirection direction);

}  // namespace plannercheck
