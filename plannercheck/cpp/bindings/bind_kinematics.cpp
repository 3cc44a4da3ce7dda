// Kinematics in Python: the table comes as arrays (plannercheck/robots/kinematics.py), poses leave as arrays.
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <vector>

#include "bindings/array_types.hpp"
#include "bindings/long_calls.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "checking/posed_in_floats.hpp"
#include "robots/kinematics.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

using PoseArray = nb::ndarray<nb::numpy, double, nb::ndim<4>>;

Rigid rigid_from(const double* row_major) {
  Rigid rigid;
  std::copy_n(row_major, 12, rigid.m);
  return rigid;
}

std::vector<JointSpec> joints_from(InputArray<int, -1> parents, InputArray<int, -1> kinds,
                                   InputArray<double, -1, 3> axes, InputArray<double, -1, 3, 4> placements,
                                   InputArray<int, -1, 7> columns, InputArray<double, -1, 7> multipliers,
                                   InputArray<double, -1, 7> offsets) {
  std::vector<JointSpec> joints(parents.shape(0));
  for (size_t i = 0; i < joints.size(); ++i) {
    joints[i].parent = parents(i);
    joints[i].kind = static_cast<JointKind>(kinds(i));
    std::copy_n(axes.data() + 3 * i, 3, joints[i].axis);
    joints[i].placement = rigid_from(placements.data() + 12 * i);
    for (size_t k = 0; k < 7; ++k) joints[i].values[k] = {columns(i, k), multipliers(i, k), offsets(i, k)};
  }
  return joints;
}

std::vector<LinkSpec> links_from(InputArray<int, -1> joints, InputArray<double, -1, 3, 4> placements) {
  std::vector<LinkSpec> links(joints.shape(0));
  for (size_t i = 0; i < links.size(); ++i) links[i] = {joints(i), rigid_from(placements.data() + 12 * i)};
  return links;
}

void check_sizes(const Kinematics& kinematics, InputArray<double, -1, -1> q, InputArray<unsigned char, -1> needed) {
  if (static_cast<int>(q.shape(1)) != kinematics.width()) throw nb::value_error("q must be (n, width)");
  if (static_cast<int>(needed.shape(0)) != kinematics.link_count()) throw nb::value_error("needed must be (links,)");
}

PoseArray pose_array(const Kinematics& kinematics, InputArray<double, -1, -1> q, InputArray<unsigned char, -1> needed) {
  check_sizes(kinematics, q, needed);
  const size_t n = q.shape(0), links = needed.shape(0);
  // calloc gives untouched zero pages, so pages of links that are not needed are never written.
  auto* data = static_cast<double*>(std::calloc(std::max<size_t>(n * links, 1), 16 * sizeof(double)));
  if (data == nullptr) throw std::bad_alloc();
  nb::capsule owner(data, [](void* p) noexcept { std::free(p); });
  without_gil([&] { kinematics.link_poses_batch(q.data(), static_cast<long long>(n), needed.data(), data); });
  return PoseArray(data, {n, links, 4, 4}, owner);
}

// What filters of sets look at: poses (n, links, 3, 4) and errors (n, links, 2).
nb::tuple float_link_poses(const Kinematics& kinematics, InputArray<double, -1, -1> q,
                           InputArray<unsigned char, -1> needed) {
  check_sizes(kinematics, q, needed);
  const size_t n = q.shape(0), links = needed.shape(0);
  const PosedInFloats found = posed_in_floats(kinematics, q.data(), n, needed.data());
  return nb::make_tuple(output_array(found.poses, {n, links, 3, 4}), output_array(found.errors, {n, links, 2}));
}

}  // namespace

void bind_kinematics(nb::module_& m) {
  nb::class_<Kinematics>(m, "Kinematics")
      .def(
          "__init__",
          [](Kinematics* self, int width, InputArray<int, -1> parents, InputArray<int, -1> kinds,
             InputArray<double, -1, 3> axes, InputArray<double, -1, 3, 4> placements, InputArray<int, -1, 7> columns,
             InputArray<double, -1, 7> multipliers, InputArray<double, -1, 7> offsets, InputArray<int, -1> link_joints,
             InputArray<double, -1, 3, 4> link_placements) {
            new (self) Kinematics(width, joints_from(parents, kinds, axes, placements, columns, multipliers, offsets),
                                  links_from(link_joints, link_placements));
          },
          plain_floats)
      .def_prop_ro("width", &Kinematics::width)
      .def_prop_ro("link_count", &Kinematics::link_count)
      .def("link_is_constant", &Kinematics::link_is_constant, plain_floats)
      .def("link_poses", &pose_array, nb::arg("q"), nb::arg("needed"), plain_floats)
      .def("float_link_poses", &float_link_poses, nb::arg("q"), nb::arg("needed"), plain_floats);
}

}  // namespace plannercheck
