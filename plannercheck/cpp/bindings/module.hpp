// Each concept binds itself in bind_<concept>.cpp, which module.cpp calls (bind_planar calls bind_planar_checker).
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <vector>

#include "bindings/array_types.hpp"

namespace plannercheck {

class CheckerCore;
struct GeometryObject;
struct Polytope;

// Bodies with the links that carry them, and where they are on these.
std::vector<GeometryObject> geometry_objects(const std::vector<std::shared_ptr<Polytope>>& bodies,
                                             InputArray<std::int32_t, -1> links,
                                             InputArray<double, -1, 4, 4> placements);

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
