// The record of tuning in Python: a member by its name. `bodies/tuning.py` has the table that fills it.
#include <nanobind/nanobind.h>

#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "checking/checker.hpp"

namespace nb = nanobind;

namespace plannercheck {

void bind_tuning(nb::module_& m) {
  nb::enum_<Solver>(m, "Solver")
      .value("oracle", Solver::kDoubleOracle)
      .value("walk", Solver::kWalk)
      .value("exact", Solver::kExact);
  nb::class_<PairOptions>(m, "PairOptions")
      .def_rw("method", &PairOptions::solver)
      .def_rw("cached_plane", &PairOptions::cached_plane)
      .def_rw("box_face", &PairOptions::box_face)
      .def_rw("centre_axis", &PairOptions::centre_axis)
      .def_rw("turned_axis", &PairOptions::turned_axis)
      .def_rw("nearest_points", &PairOptions::nearest_points)
      .def_rw("double_double", &PairOptions::double_double)
      .def_rw("warm_start", &PairOptions::warm_start)
      .def_rw("trees_first", &PairOptions::trees_first)
      .def_rw("dents", &PairOptions::dents)
      .def_rw("part_trees", &PairOptions::part_trees);
  nb::class_<Tuning, PairOptions>(m, "Tuning")
      .def(nb::init<>(), plain_floats)
      .def_rw("bounds", &Tuning::bounds)
      .def_rw("boxes", &Tuning::boxes)
      .def_rw("overlaps", &Tuning::overlaps)
      .def_rw("learning", &Tuning::learning)
      .def_rw("sorted_states", &Tuning::sorted_states)
      .def_rw("float_poses", &Tuning::float_poses)
      .def_rw("thin_tubes", &Tuning::thin_tubes)
      .def_rw("hollows", &Tuning::hollows)
      .def_rw("covers", &Tuning::covers)
      .def_rw("halves", &Tuning::halves);
}

}  // namespace plannercheck
