#include "bodies/half_space.hpp"

#include <limits>

#include "math/box.hpp"

namespace plannercheck {
namespace {

constexpr double kUnboundedEdge = 1e60;  // half of the cube's, m: bodies have coordinates up to 1e50

}  // namespace

WorldPlane world_plane(const HalfSpace& half_space, const Pose& pose) {
  const PlaneInWorld<double, Vec3> plane = posed_plane<double, Vec3>(half_space, pose);
  const double inverse = 1 / norm(plane.normal);
  const Vec3 normal = inverse * plane.normal;
  return {normal, plane.offset * inverse + dot(normal, pose.translation())};
}

Polytope polytope_of(const HalfSpace& half_space, double inflation_radius) {
  Polytope body = prepare_polytope(Box{{}, {}}.grown(kUnboundedEdge).corners());
  body.is_box = 0;
  body.radius = std::numeric_limits<double>::infinity();  // poses may be further away than the cube reaches
  body.inflation_radius = inflation_radius;
  body.dents.deepest = kUnknownDent;
  body.shape = std::make_shared<const HalfSpace>(half_space);
  return body;
}

}  // namespace plannercheck
