// Shapes as coal has them, for coal_loop.cpp.
//
// In: a kind, and lengths, or points and triangles. Out: one of coal's geometries. A mesh is a tree of boxes around its
// triangles, so it is a surface.
#pragma once

#include <coal/BVH/BVH_model.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <memory>
#include <stdexcept>
#include <vector>

// A mesh has boxes in any direction around its triangles; or these and swept spheres, as Pinocchio loads meshes.
enum Kind { kBox, kSphere, kCapsule, kCylinder, kCone, kHull, kMesh, kMeshWithSweptSpheres };

template <typename Box>
std::unique_ptr<coal::CollisionGeometry> coal_mesh(const std::vector<coal::Vec3s>& corners,
                                                   const std::vector<coal::Triangle>& faces) {
  auto model = std::make_unique<coal::BVHModel<Box>>();
  const bool is_made =
      model->beginModel(static_cast<unsigned>(faces.size()), static_cast<unsigned>(corners.size())) == coal::BVH_OK &&
      model->addSubModel(corners, faces) == coal::BVH_OK && model->endModel() == coal::BVH_OK;
  if (!is_made) throw std::runtime_error("it makes no tree of this mesh");
  return model;
}

inline std::unique_ptr<coal::CollisionGeometry> coal_shape(int kind, const double* numbers, const double* points, int n,
                                                           const int* triangles, int m) {
  switch (kind) {
    case kBox:
      return std::make_unique<coal::Box>(numbers[0], numbers[1], numbers[2]);
    case kSphere:
      return std::make_unique<coal::Sphere>(numbers[0]);
    case kCapsule:
      return std::make_unique<coal::Capsule>(numbers[0], numbers[1]);
    case kCylinder:
      return std::make_unique<coal::Cylinder>(numbers[0], numbers[1]);
    case kCone:
      return std::make_unique<coal::Cone>(numbers[0], numbers[1]);
    default:
      break;
  }
  auto corners = std::make_shared<std::vector<coal::Vec3s>>();
  auto faces = std::make_shared<std::vector<coal::Triangle>>();
  for (int k = 0; k < n; ++k) corners->emplace_back(points[3 * k], points[3 * k + 1], points[3 * k + 2]);
  for (int k = 0; k < m; ++k) faces->emplace_back(triangles[3 * k], triangles[3 * k + 1], triangles[3 * k + 2]);
  if (kind == kMesh) return coal_mesh<coal::OBB>(*corners, *faces);
  if (kind == kMeshWithSweptSpheres) return coal_mesh<coal::OBBRSS>(*corners, *faces);
  return std::make_unique<coal::Convex<coal::Triangle>>(corners, n, faces, m);
}
