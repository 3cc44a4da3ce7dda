// The Python module: one a SIMD level, all with the same content.
#include "bindings/module.hpp"

#include "math/simd.hpp"

NB_MODULE(PLANNERCHECK_MODULE, m) {
  // Python does not clear what modules and caches still hold at its exit; that is no leak that users could mend.
  nanobind::set_leak_warnings(false);
  m.attr("level") = PLANNERCHECK_LEVEL;
  m.attr("lanes") = plannercheck::kLanes;
  plannercheck::bind_polytope(m);
  plannercheck::bind_kinematics(m);
  plannercheck::bind_checker(m);
  plannercheck::bind_sphere_model(m);
  plannercheck::bind_planar(m);
  plannercheck::bind_planar_motion(m);
  plannercheck::bind_motion(m);
  plannercheck::bind_distance(m);
  plannercheck::bind_game(m);
}
