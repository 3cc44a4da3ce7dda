// Each concept binds itself in bind_<concept>.cpp, which module.cpp calls (bind_planar calls bind_planar_checker).
#pragma once

#include <nanobind/nanobind.h>

#include <memory>

namespace plannercheck {

class CheckerCore;

// The core of a Checker of Python's, which keeps that Checker alive.
std::shared_ptr<const CheckerCore> shared_checker_core(nanobind::object checker);

void bind_kinematics(nanobind::module_& m);
void bind_part_set(nanobind::module_& m);
void bind_solid(nanobind::module_& m);
void bind_tuning(nanobind::module_& m);
void bind_polytope(nanobind::module_& m);
void bind_ompl_states(nanobind::module_& m);
void bind_checker(nanobind::module_& m);
void bind_planar(nanobind::module_& m);
void bind_planar_checker(nanobind::module_& m);
void bind_planar_motion(nanobind::module_& m);
void bind_motion(nanobind::module_& m);
void bind_distance(nanobind::module_& m);
void bind_distance_tables(nanobind::module_& m);
void bind_pair_queries(nanobind::module_& m);
void bind_points(nanobind::module_& m);
void bind_game(nanobind::module_& m);
void bind_reach(nanobind::module_& m);
void bind_compiled_first(nanobind::module_& m);

}  // namespace plannercheck
