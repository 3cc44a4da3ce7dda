#include "oracle/winding.hpp"

#include "oracle/triangles.hpp"

namespace plannercheck::oracle {
namespace {

constexpr int kX = 0, kY = 1, kZ = 2;

// On which side of the edge from a to b, projected along x, the moved point lies; 0 only if the edge becomes a point.
// (b − a) × (point − a) = (b − a)_y (point − a)_z − (b − a)_z (point − a)_y.
int side_of_moved(const MeshPair& pair, const Corner& a, const Corner& b, const Corner& point) {
  const int side = orientation_in_plane(pair, a, b, point, kX);
  if (side != 0) return side;
  const int by_y = compare(pair, a, b, kZ);
  return by_y != 0 ? by_y : compare(pair, b, a, kY);
}

bool is_off(const Interval& of_point, const Interval& a, const Interval& b, const Interval& c) {
  return (a.high < of_point.low() && b.high < of_point.low() && c.high < of_point.low()) ||
         (a.low() > of_point.high && b.low() > of_point.high && c.low() > of_point.high);
}

// Whether the ray misses the triangle by its coordinates alone.
bool is_aside(const Corner& point, const Triangle& t) {
  const auto about = [](const Corner& c) -> const IntervalVector& { return c.of->about(c.vertex); };
  const IntervalVector &q = about(point), &a = about(t[0]), &b = about(t[1]), &c = about(t[2]);
  const bool is_behind = a.x.high < q.x.low() && b.x.high < q.x.low() && c.x.high < q.x.low();
  return is_behind || is_off(q.y, a.y, b.y, c.y) || is_off(q.z, a.z, b.z, c.z);
}

}  // namespace

std::optional<std::int64_t> winding_number(const MeshPair& pair, const Corner& point, const PosedMesh& mesh) {
  std::int64_t winding = 0;
  for (std::size_t i = 0; i < mesh.mesh().triangles.size(); ++i) {
    const Triangle t = triangle_of(mesh, i);
    if (pair.uses_intervals() && is_aside(point, t)) continue;
    const int side = side_of_moved(pair, t[0], t[1], point);
    if (side == 0 || side_of_moved(pair, t[1], t[2], point) != side || side_of_moved(pair, t[2], t[0], point) != side)
      continue;
    const int above = orientation(pair, t[0], t[1], t[2], point);
    if (above == 0) return std::nullopt;
    if (above != side) winding += side;
  }
  return winding;
}

}  // namespace plannercheck::oracle
