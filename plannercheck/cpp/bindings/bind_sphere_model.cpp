// The sphere model in Python, from arrays (plannercheck/evaluation/bench/sphere_model.py).
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "bindings/array_types.hpp"
#include "bindings/gil.hpp"
#include "bindings/module.hpp"
#include "bindings/plain_floats.hpp"
#include "evaluation/sphere_model.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

float as_float(double value) { return static_cast<float>(value); }

// links: (bodies); balls: (balls, 4) centre and radius; starts: (bodies + 1) into them. kinds: (obstacles); to_local:
// (obstacles, 4, 4); sizes: (obstacles, 4) half sizes and rounding; planes: (planes, 4); plane_starts: (obstacles + 1).
SphereModel::Parts parts_from(InputArray<std::int32_t, -1> links, InputArray<double, -1, 4> balls,
                              InputArray<std::int32_t, -1> starts, InputArray<std::int32_t, -1> kinds,
                              InputArray<double, -1, 4, 4> to_local, InputArray<double, -1, 4> sizes,
                              InputArray<double, -1, 4> planes, InputArray<std::int32_t, -1> plane_starts,
                              InputArray<std::int32_t, -1, 2> pairs, std::int32_t link_count) {
  SphereModel::Parts parts;
  parts.links = link_count;
  for (std::size_t i = 0; i < balls.shape(0); ++i) {
    parts.balls.push_back({{balls(i, 0), balls(i, 1), balls(i, 2)}, as_float(balls(i, 3))});
  }
  for (std::size_t i = 0; i < links.shape(0); ++i) {
    parts.bodies.push_back({links(i), starts(i), starts(i + 1) - starts(i)});
  }
  for (std::size_t i = 0; i < kinds.shape(0); ++i) {
    SphereModel::Obstacle o{static_cast<SphereModel::Kind>(kinds(i)), {}, {}, as_float(sizes(i, 3)), plane_starts(i),
                            plane_starts(i + 1) - plane_starts(i)};
    for (std::size_t k = 0; k < 12; ++k) o.to_local[k] = as_float(to_local(i, k / 4, k % 4));
    for (std::size_t k = 0; k < 3; ++k) o.half[k] = as_float(sizes(i, k));
    parts.obstacles.push_back(o);
  }
  for (std::size_t i = 0; i < planes.shape(0); ++i) {
    parts.planes.push_back(
        {as_float(planes(i, 0)), as_float(planes(i, 1)), as_float(planes(i, 2)), as_float(planes(i, 3))});
  }
  for (std::size_t i = 0; i < pairs.shape(0); ++i) parts.pairs.push_back({pairs(i, 0), pairs(i, 1)});
  return parts;
}

auto check_ball_states(const SphereModel& model, const Kinematics& kinematics, InputArray<double, -1, -1> q) {
  std::vector<std::uint8_t> valid(q.shape(0));
  {
    const GilReleased released;
    model.check_states(kinematics, q.data(), valid.size(), valid.data());
  }
  return output_array(valid, {valid.size()});
}

}  // namespace

void bind_sphere_model(nb::module_& m) {
  nb::class_<SphereModel>(m, "SphereModel")
      .def(
          "__init__",
          [](SphereModel* self, InputArray<std::int32_t, -1> links, InputArray<double, -1, 4> balls,
             InputArray<std::int32_t, -1> starts, InputArray<std::int32_t, -1> kinds,
             InputArray<double, -1, 4, 4> to_local, InputArray<double, -1, 4> sizes, InputArray<double, -1, 4> planes,
             InputArray<std::int32_t, -1> plane_starts, InputArray<std::int32_t, -1, 2> pairs,
             std::int32_t link_count) {
            new (self) SphereModel(
                parts_from(links, balls, starts, kinds, to_local, sizes, planes, plane_starts, pairs, link_count));
          },
          plain_floats)
      .def("bytes", &SphereModel::bytes, plain_floats)
      .def("check_states", &check_ball_states, plain_floats);
}

}  // namespace plannercheck
