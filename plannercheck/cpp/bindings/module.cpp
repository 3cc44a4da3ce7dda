// The Python module: one a SIMD level, all with the same content.
#include "bindings/module.hpp"

#include "math/simd.hpp"

NB_MODULE(PLANNERCHECK_MODULE, m) {
  // Objects that modules and caches hold at Python's exit would be reported as leaks, which users cannot mend.
  nanobind::set_leak_warnings(false);
  m.attr("level") = PLANNERCHECK_LEVEL;
  m.attr("lanes") = plannercheck::kLanes;
  plannercheck::bind_part_set(m);
  plannercheck::bind_solid(m);
  plannercheck::bind_tuning(m);
  plannercheck::bind_polytope(m);
  plannercheck::bind_kinematics(m);
  plannercheck::bind_ompl_states(m);
  plannercheck::bind_checker(m);
  plannercheck::bind_planar(m);
  plannercheck::bind_planar_motion(m);
  plannercheck::bind_motion(m);
  plannercheck::bind_distance(m);
  plannercheck::bind_distance_tables(m);
  plannercheck::bind_pair_queries(m);
  plannercheck::bind_points(m);
  plannercheck::bind_game(m);
  plannercheck::bind_reach(m);
  plannercheck::bind_compiled_first(m);
}
