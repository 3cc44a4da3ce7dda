#include "planar/swept_distance_2d.hpp"

#include <array>
#include <cmath>

namespace plannercheck {
namespace {

constexpr int kPlanarRounds = 48;

// A new difference that is nearer by less than this part is no progress.
constexpr double kPlanarProgress = 1e-12;

double planar_dot(PlanarVector a, PlanarVector b) { return a.x * b.x + a.y * b.y; }
PlanarVector planar_minus(PlanarVector a, PlanarVector b) { return {a.x - b.x, a.y - b.y}; }

// The vertex furthest against a direction.
PlanarVector lowest_vertex(const PlanarHull& hull, PlanarVector d) {
  std::size_t lowest = 0;
  double least = d.x * hull.x[0] + d.y * hull.y[0];
  for (std::size_t k = 1; k < hull.x.size(); ++k) {
    const double along = d.x * hull.x[k] + d.y * hull.y[k];
    lowest = along < least ? k : lowest;
    least = along < least ? along : least;
  }
  return {hull.x[lowest], hull.y[lowest]};
}

PlanarVector lowest_posed(const PlanarHull& hull, const PlanarPlace& place, PlanarVector d) {
  const PlanarVector v = place.turned(lowest_vertex(hull, place.turned_back(d)));
  return {v.x + place.x, v.y + place.y};
}

struct PlanarDifference {
  PlanarVector point;  // in the frame
  double along;
};

PlanarDifference planar_difference(const PlanarHull& a, const PlanarHull& b, const PlanarPlaces& places,
                                   PlanarDirection direction) {
  const PlanarVector d = places.frame.turned(direction.vector());
  const PlanarVector w = planar_minus(lowest_posed(a, places.a, d), lowest_posed(b, places.b, {-d.x, -d.y}));
  return {places.frame.turned_back(w), planar_dot(d, w)};
}

// Up to three points, reduced to the corners of the face that holds the point nearest to the origin.
struct PlanarSimplex {
  int count = 0;
  std::array<PlanarVector, 3> point;
};

PlanarVector nearest_of_two(PlanarSimplex& s, PlanarVector a, PlanarVector b) {
  const PlanarVector ab = planar_minus(b, a);
  const double t = -planar_dot(a, ab), square = planar_dot(ab, ab);
  if (!(t > 0)) return s = {1, {a}}, a;
  if (t >= square) return s = {1, {b}}, b;
  s = {2, {a, b}};
  return {a.x + t / square * ab.x, a.y + t / square * ab.y};
}

// If the origin is inside, the origin itself, and all corners are kept.
PlanarVector nearest_of_three(PlanarSimplex& s) {
  const std::array<PlanarVector, 3> p = s.point;
  const auto area = [](PlanarVector a, PlanarVector b) { return a.x * b.y - a.y * b.x; };
  const double u = area(p[0], p[1]), v = area(p[1], p[2]), w = area(p[2], p[0]);
  if ((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0)) return {};
  PlanarVector best = nearest_of_two(s, p[0], p[1]);
  for (std::size_t k = 1; k < 3; ++k) {
    PlanarSimplex side;
    const PlanarVector near = nearest_of_two(side, p[k], p[(k + 1) % 3]);
    if (planar_dot(near, near) < planar_dot(best, best)) best = near, s = side;
  }
  return best;
}

PlanarVector nearest_of(PlanarSimplex& s) {
  if (s.count == 1) return s.point[0];
  return s.count == 2 ? nearest_of_two(s, s.point[0], s.point[1]) : nearest_of_three(s);
}

}  // namespace

double planar_gap(const PlanarHull& a, const PlanarHull& b, const PlanarPlaces& places, PlanarDirection direction) {
  return planar_difference(a, b, places, direction).along;
}

SweptAnswer<PlanarDirection> planar_apart(const PlanarHull& a, const PlanarHull& b, const PlanarPlaces* places,
                                          int count, double limit, PlanarDirection hint) {
  SweptAnswer<PlanarDirection> answer;
  PlanarSimplex simplex;
  PlanarDirection d = hint;
  double length = 0, square = 0;  // |v| and |v|² once v is a point of the simplex
  for (int round = 0; round < kPlanarRounds; ++round) {
    PlanarDifference lowest = planar_difference(a, b, places[0], d);
    if (count > 1) {
      const PlanarDifference other = planar_difference(a, b, places[1], d);
      if (other.along < lowest.along) lowest = other;
    }
    if (round == 0 || lowest.along > answer.gap) answer.direction = d, answer.gap = lowest.along;
    answer.apart = lowest.along > limit;
    if (answer.apart) return answer;
    // The new vertex is no nearer to the origin than the simplex: as near as doubles can tell.
    if (simplex.count > 0 && length - lowest.along <= kPlanarProgress * length) return answer;
    simplex.point[static_cast<std::size_t>(simplex.count++)] = lowest.point;
    const PlanarVector v = nearest_of(simplex);
    const double now = planar_dot(v, v);
    if (now <= limit * limit || simplex.count == 3 || (round > 0 && now >= square)) return answer;
    square = now, length = std::sqrt(now), d = PlanarDirection::along(v);
  }
  return answer;
}

}  // namespace plannercheck
