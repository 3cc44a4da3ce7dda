// Meshes in the oracle's Python module.
#include <nanobind/stl/optional.h>

#include <cstdint>
#include <optional>

#include "oracle/given_arrays.hpp"
#include "oracle/mesh_pairs.hpp"
#include "oracle/winding.hpp"

namespace plannercheck::oracle {
namespace {

using Corners = nb::ndarray<const std::int32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

Mesh mesh_of(Doubles<-1, 3> vertices, Corners triangles, double inflation_radius) {
  check_finite(vertices.data(), 3 * vertices.shape(0), "vertices");
  check_finite(&inflation_radius, 1, "the inflation radius");
  if (triangles.shape(0) == 0 || inflation_radius < 0)
    throw std::invalid_argument("at least one triangle, and an inflation radius of at least 0");
  const auto count = static_cast<std::int64_t>(vertices.shape(0));
  const std::int32_t* corners = triangles.data();
  if (!std::all_of(corners, corners + 3 * triangles.shape(0), [&](std::int32_t c) { return 0 <= c && c < count; }))
    throw std::invalid_argument("indices of triangles have to be those of vertices");
  return Mesh(vertices.data(), vertices.shape(0), corners, triangles.shape(0), inflation_radius);
}

// Reasons (n,), see Meeting.
Verdicts decide(const Mesh& p, Doubles<-1, 4, 4> poses_p, const Mesh& r, Doubles<-1, 4, 4> poses_r, bool every) {
  const std::size_t count = poses_p.shape(0);
  if (poses_r.shape(0) != count) throw std::invalid_argument("as many poses of one body as of the other");
  check_finite(poses_p.data(), kPoseNumbers * count, "poses");
  check_finite(poses_r.data(), kPoseNumbers * count, "poses");
  auto reasons = std::make_unique<std::uint8_t[]>(std::max<std::size_t>(count, 1));
  {
    const GilReleased released;
    const RoundedUpwards rounded;
    for (std::size_t i = 0; i < count; ++i) {
      const MeshPair pair(p, poses_p.data() + kPoseNumbers * i, r, poses_r.data() + kPoseNumbers * i, every);
      reasons[i] = static_cast<std::uint8_t>(meeting(pair, every));
    }
  }
  return as_array(std::move(reasons), count);
}

// Around a point in the mesh's own frame; nothing if it may lie on a triangle.
std::optional<std::int64_t> winding_of(const Mesh& mesh, Doubles<3> point, bool every) {
  check_finite(point.data(), 3, "the point");
  constexpr double kAsItLies[kPoseNumbers] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  constexpr std::int32_t kOneCorner[] = {0, 0, 0};
  const Mesh single(point.data(), 1, kOneCorner, 1, 0);
  const RoundedUpwards rounded;
  const MeshPair pair(single, kAsItLies, mesh, kAsItLies, every);
  return winding_number(pair, {&pair.p, 0}, pair.r);
}

}  // namespace

void bind_meshes(nb::module_& m) {
  nb::class_<Mesh>(m, "Mesh")
      .def(
          "__init__",
          [](Mesh* self, Doubles<-1, 3> vertices, Corners triangles, double inflation_radius) {
            new (self) Mesh(mesh_of(vertices, triangles, inflation_radius));
          },
          nb::arg("vertices"), nb::arg("triangles"), nb::arg("inflation_radius"))
      .def_prop_ro("is_closed", [](const Mesh& mesh) { return mesh.is_closed; })
      .def_prop_ro("components", [](const Mesh& mesh) { return mesh.component_vertices.size(); })
      .def("winding_number", &winding_of, nb::arg("point"), nb::arg("every"));
  m.def("decide_meshes", &decide, nb::arg("p"), nb::arg("poses_p"), nb::arg("r"), nb::arg("poses_r"), nb::arg("every"));
}

}  // namespace plannercheck::oracle
