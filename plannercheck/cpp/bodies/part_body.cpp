#include "bodies/part_body.hpp"

#include <limits>
#include <vector>

namespace plannercheck {

void PartBody::fill(const PartShape& part, double more) {
  if (body_.inner.points.size() != part.corners) {
    const std::vector<Vec3> points(part.corners);
    body_.inner = Hierarchy{lay_out(points, {}, indices_below(part.corners), 0), {}};
    body_.polar_radius = std::numeric_limits<double>::infinity();
  }
  Levels& levels = body_.inner;
  if (part.corners == 1) return fill_point(part.corner[0], part.radius + more);
  body_.dimension = 3;
  body_.inflation_radius = part.radius + more;
  levels.largest_coordinate = body_.origin_radius = body_.radius = 0;
  body_.low = body_.high = part.corner[0];
  body_.centre = {};
  const double weight = 1 / static_cast<double>(part.corners);
  for (std::size_t c = 0; c < part.corners; ++c) {
    const Vec3 p = part.corner[c];
    levels.points[c] = p;
    levels.largest_coordinate = larger(levels.largest_coordinate, norm_max(p));
    body_.low = smaller(body_.low, p), body_.high = larger(body_.high, p);
    body_.centre = body_.centre + weight * p;
    body_.origin_radius = larger(body_.origin_radius, norm_above(p));
  }
  for (std::size_t c = 0; c < part.corners; ++c) {
    body_.radius = larger(body_.radius, norm_above(part.corner[c] - body_.centre));
  }
  const double unit = levels.largest_coordinate > 0 ? levels.largest_coordinate : 1;
  for (std::size_t i = 0; i < levels.top.size(); ++i) {
    const Vec3 p = levels.points[at(levels.top[i])];
    levels.top_blocks[i / kScanLanes].put(i % kScanLanes, p, unit);
    VertexBlock& cursors = levels.top_cursors[i / kBlockLanes];
    cursors.x[i % kBlockLanes] = p.x, cursors.y[i % kBlockLanes] = p.y, cursors.z[i % kBlockLanes] = p.z;
  }
}

void PartBody::fill_point(Vec3 p, double radius) {
  Levels& levels = body_.inner;
  body_.dimension = 0;
  body_.inflation_radius = radius;
  body_.low = body_.high = body_.centre = levels.points[0] = p;
  body_.radius = 0;
  body_.origin_radius = norm_above(p);
  levels.largest_coordinate = norm_max(p);
  const double unit = levels.largest_coordinate > 0 ? 1 / levels.largest_coordinate : 1;
  ScanBlock& scan = levels.top_blocks[0];
  scan.x.fill(static_cast<float>(p.x * unit)), scan.y.fill(static_cast<float>(p.y * unit));
  scan.z.fill(static_cast<float>(p.z * unit));
  for (VertexBlock& cursors : levels.top_cursors) cursors.x.fill(p.x), cursors.y.fill(p.y), cursors.z.fill(p.z);
}

Polytope polytope_of(const PartShape& part, double more) {
  Polytope body = prepare_polytope(
      std::vector<Vec3>(part.corner.begin(), part.corner.begin() + static_cast<std::ptrdiff_t>(part.corners)));
  body.inflation_radius = part.radius + more;
  return body;
}

}  // namespace plannercheck
