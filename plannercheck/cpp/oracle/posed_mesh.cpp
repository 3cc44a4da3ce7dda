#include "oracle/posed_mesh.hpp"

#include <algorithm>

namespace plannercheck::oracle {
namespace {

constexpr std::size_t kShift = 3;  // the column of a pose that holds it

Interval row_about(const double* row, const double* v, double origin) {
  return Interval(row[0]) * Interval(v[0]) + Interval(row[1]) * Interval(v[1]) + Interval(row[2]) * Interval(v[2]) +
         (Interval(row[kShift]) - Interval(origin));
}

std::array<double, 3> shift_of(const double* pose) { return {pose[kShift], pose[kShift + 4], pose[kShift + 8]}; }

bool is_small(const Interval& x) { return x.high < kLargestInIntervals && x.negated_low < kLargestInIntervals; }

}  // namespace

PosedMesh::PosedMesh(const Mesh& mesh, const double* pose, const double* origin)
    : mesh_(&mesh), posed_(mesh.points, pose), exactly_(mesh.coordinates.size() / 3) {
  about_.reserve(exactly_.size());
  for (std::size_t i = 0; i < exactly_.size(); ++i) {
    const double* v = mesh.coordinates.data() + 3 * i;
    about_.push_back(
        {row_about(pose, v, origin[0]), row_about(pose + 4, v, origin[1]), row_about(pose + 8, v, origin[2])});
  }
  fits_intervals_ =
      std::all_of(about_.begin(), about_.end(),
                  [](const IntervalVector& v) { return is_small(v.x) && is_small(v.y) && is_small(v.z); }) &&
      mesh.inflation_radius < kLargestInIntervals;
}

const Vector& PosedMesh::exactly(std::uint32_t vertex) const {
  if (!exactly_[vertex]) exactly_[vertex] = std::make_unique<Vector>(posed_.point(vertex));
  return *exactly_[vertex];
}

MeshPair::MeshPair(const Mesh& first, const double* pose_first, const Mesh& second, const double* pose_second,
                   bool every)
    : p(first, pose_first, shift_of(pose_second).data()),
      r(second, pose_second, shift_of(pose_second).data()),
      uses_intervals_(!every && p.fits_intervals() && r.fits_intervals()),
      radius_about_(Interval(first.inflation_radius) + Interval(second.inflation_radius)) {
  const int unit = std::min(p.unit(), r.unit());
  p.use_unit(unit), r.use_unit(unit);
  radius_exactly_ = p.inflation_radius() + r.inflation_radius();
}

}  // namespace plannercheck::oracle
