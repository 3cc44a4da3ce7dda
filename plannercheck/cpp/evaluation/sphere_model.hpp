// A robot as balls on its links against obstacles in closed form, eight states at once in floats: the check of planners
// that approximate links by spheres. Only `plannercheck bench` uses it, for comparison.
//
// In: balls around bodies (plannercheck/evaluation/bench/sphere_model.py fits them), obstacles as rounded boxes,
// cylinders or planes, pairs. Out: for each configuration whether no balls of a pair meet. The ball around a whole body
// is tested first; a body's fine balls are posed when first needed; a block ends once all its states collide.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/vec.hpp"
#include "robots/kinematics.hpp"

namespace plannercheck {

class SphereModel {
 public:
  struct Ball {
    Vec3 centre;  // in the link's frame, m
    float radius;
  };

  // The first ball holds all others.
  struct Body {
    std::int32_t link;
    std::int32_t first_ball, balls;
  };

  enum class Kind : std::int32_t { kRoundedBox, kCylinder, kPlanes };

  struct Obstacle {
    Kind kind;
    std::array<float, 12> to_local;  // row-major 3x4
    std::array<float, 3> half;       // of a box; a cylinder has its radius first and half its length last
    float radius;                    // of a box's rounding
    std::int32_t first_plane, planes;
  };

  // n·x <= offset inside; n is a unit vector.
  struct Plane {
    float x, y, z, offset;
  };

  struct Parts {
    std::vector<Ball> balls;
    std::vector<Body> bodies;
    std::vector<Obstacle> obstacles;
    std::vector<Plane> planes;
    std::vector<std::array<std::int32_t, 2>> pairs;  // a body, and a body or (numbered after the bodies) an obstacle
    std::int32_t links;
  };

  struct Centres;  // of a ball in a block of states

  explicit SphereModel(Parts parts);

  // For each of n configurations (n, width): whether no pair meets.
  void check_states(const Kinematics& kinematics, const double* q, std::size_t n, std::uint8_t* valid) const;

  std::size_t bytes() const;

 private:
  struct Workspace;

  Parts parts_;
  std::vector<unsigned char> needed_;  // links that carry some body

  unsigned judge(unsigned states, Workspace& workspace) const;
  unsigned hits_obstacle(const Body& body, const Obstacle& obstacle, unsigned states, Workspace& workspace) const;
  unsigned hits_body(const Body& a, const Body& b, unsigned states, Workspace& workspace) const;
};

}  // namespace plannercheck
