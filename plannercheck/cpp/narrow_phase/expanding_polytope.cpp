#include "narrow_phase/expanding_polytope.hpp"

#include <algorithm>
#include <limits>

#include "math/double_double.hpp"

namespace plannercheck {
namespace {

// With N = (b − a) × (c − a) and E = |b − a| |c − a|: N in doubles errs by 1u of each difference and 2u of each product
// and their difference, at most 4√2 u E as a vector; a·N by 3u |a| |N| more. The height a·N / |N| moves by twice the
// normal's error over |N|, times |a|: 11.4u |a| E / |N|, and by 9u |a| in products, norm, quotient and rounding a's
// length.
constexpr double kPlaneError = 16 * 0x1p-53, kFacetHeightError = 16 * 0x1p-53;
// As above, with N and a·N in double-double, of error e = 2^-102 an operation: 24e |a| E / |N|; the height in doubles
// errs by 6u of itself.
constexpr double kFinePlaneError = 64 * kDoubleDoubleError, kFineHeightError = 16 * 0x1p-53;

std::size_t after(std::size_t edge) { return edge == 2 ? 0 : edge + 1; }

constexpr double kNoHeight = -std::numeric_limits<double>::infinity();

}  // namespace

FinePlane::FinePlane(Vec3 a, Vec3 b, Vec3 c) : height(kNoHeight) {
  const DoubleDoubleVec3 one = difference(b, a), two = difference(c, a), fine_normal = cross(one, two);
  const Vec3 n = rounded(fine_normal);
  const double area = norm_at_any_scale(n), edges = norm(rounded(one)) * norm(rounded(two));
  if (!(area > 0)) return;
  const double over = dot(widen(a), fine_normal).high / area;
  normal = (1 / area) * n;
  height = over - (std::fabs(over) * kFineHeightError + norm(a) * (kFinePlaneError * edges / area));
}

void ExpandingPolytope::Fan::find_planes(Vec3 apex, std::size_t count) {
  const double length = norm(apex);
  for (std::size_t k = 0; k < count; ++k) {  // without branches, so that it is done in lanes
    const double ax = x[k], ay = y[k], az = z[k], bx = x[k + 1], by = y[k + 1], bz = z[k + 1];
    const double nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx;
    const double inverse = 1 / std::sqrt(nx * nx + ny * ny + nz * nz);
    const double edges = std::sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz));
    normal_x[k] = inverse * nx, normal_y[k] = inverse * ny, normal_z[k] = inverse * nz;
    offset[k] = normal_x[k] * apex.x + normal_y[k] * apex.y + normal_z[k] * apex.z;
    height[k] = offset[k] - length * (kPlaneError * (edges * inverse) + kFacetHeightError);
  }
}

void ExpandingPolytope::start(const std::array<Vec3, 4>& corners, double tie) {
  faces_.clear(), planes_.clear(), heights_.clear(), unused_.clear();
  tie_ = tie;
  points_.assign(corners.begin(), corners.end());
  const auto [a, b, c, d] = corners;
  const bool turned = dot(cross(b - a, c - a), d - a) > 0;
  const std::int32_t p = 0, q = turned ? 2 : 1, r = turned ? 1 : 2, s = 3;  // s is below p q r
  for (const std::array<std::int32_t, 3>& corner : {std::array{p, q, r}, {q, p, s}, {r, q, s}, {p, r, s}}) {
    const std::int32_t f = new_face(corner);
    const Vec3 apex = point(corner[2]);
    fan_.put(0, point(corner[0]) - apex), fan_.put(1, point(corner[1]) - apex);
    fan_.find_planes(apex, 1);
    set_plane(f, 0);
  }
  for (std::int32_t k = 0; k < 3; ++k) {
    link(0, at(k), k + 1, 0);
    link(k + 1, 2, (k + 1) % 3 + 1, 1);
  }
}

std::int32_t ExpandingPolytope::nearest() const {
  double least = std::numeric_limits<double>::infinity();
  std::size_t found = 0;
  for (std::size_t f = 0; f < heights_.size(); ++f) {
    found = heights_[f] < least ? f : found;
    least = smaller(heights_[f], least);
  }
  return static_cast<std::int32_t>(found);
}

bool ExpandingPolytope::expand(std::int32_t from, Vec3 corner) {
  horizon_.clear();
  const Face first_seen = faces_[at(from)];
  remove(from);
  for (std::size_t e = 0; e < 3; ++e) find_horizon(first_seen.across[e], first_seen.across_edge[e], corner);
  if (!is_one_circuit()) return false;
  const auto apex = static_cast<std::int32_t>(points_.size());
  points_.push_back(corner);
  const auto start_of = [&](const HorizonEdge& edge) { return faces_[at(edge.face)].corner[after(at(edge.edge))]; };
  std::int32_t first = -1, last = -1;
  for (std::size_t start = 0; start < horizon_.size(); start += kFan) {
    const std::size_t count = std::min(kFan, horizon_.size() - start);
    const HorizonEdge* const edges = &horizon_[start];
    fan_.put(0, point(start_of(edges[0])) - corner);
    for (std::size_t k = 0; k < count; ++k)
      fan_.put(k + 1, point(faces_[at(edges[k].face)].corner[at(edges[k].edge)]) - corner);
    fan_.find_planes(corner, count);
    for (std::size_t k = 0; k < count; ++k) {
      const HorizonEdge edge = edges[k];
      const std::int32_t f = new_face({start_of(edge), faces_[at(edge.face)].corner[at(edge.edge)], apex});
      link(f, 0, edge.face, at(edge.edge));
      if (last >= 0) link(last, 1, f, 2);
      if (first < 0) first = f;
      set_plane(f, k);
      last = f;
    }
  }
  link(last, 1, first, 2);
  return true;
}

// In the order of a walk around what is seen: faces that are entered through an edge are left through the next two.
void ExpandingPolytope::find_horizon(std::int32_t f, std::int32_t edge, Vec3 corner) {
  const Face& face = faces_[at(f)];
  if (!face.alive) return;
  const Plane& plane = planes_[at(f)];
  if (!(dot(plane.normal, corner) - plane.offset > tie_)) return horizon_.push_back({f, edge});
  const std::size_t second = after(at(edge)), third = after(second);
  remove(f);
  find_horizon(face.across[second], face.across_edge[second], corner);
  find_horizon(face.across[third], face.across_edge[third], corner);
}

// A circuit may pass a corner twice: the cone over it is closed all the same.
bool ExpandingPolytope::is_one_circuit() const {
  if (horizon_.size() < 3) return false;
  std::int32_t last = faces_[at(horizon_.back().face)].corner[at(horizon_.back().edge)];
  for (const HorizonEdge& edge : horizon_) {
    const Face& beyond = faces_[at(edge.face)];
    if (!beyond.alive || beyond.corner[after(at(edge.edge))] != last) return false;
    last = beyond.corner[at(edge.edge)];
  }
  return true;
}

void ExpandingPolytope::refine(std::int32_t f) {
  const auto [a, b, c] = corners(f);
  const FinePlane fine(point(a), point(b), point(c));
  planes_[at(f)] = {fine.normal, dot(fine.normal, point(c))};
  heights_[at(f)] = fine.height;
  faces_[at(f)].refined = true;
}

std::int32_t ExpandingPolytope::new_face(const std::array<std::int32_t, 3>& corner) {
  std::int32_t f = static_cast<std::int32_t>(faces_.size());
  if (unused_.empty()) {
    faces_.emplace_back(), planes_.emplace_back(), heights_.emplace_back();
  } else {
    f = unused_.back();
    unused_.pop_back();
  }
  Face& face = faces_[at(f)];
  face.corner = corner, face.alive = true, face.refined = false;
  return f;
}

void ExpandingPolytope::remove(std::int32_t f) {
  faces_[at(f)].alive = false;
  heights_[at(f)] = std::numeric_limits<double>::infinity();
  unused_.push_back(f);
}

void ExpandingPolytope::set_plane(std::int32_t f, std::size_t in_fan) {
  const Fan& fan = fan_;
  planes_[at(f)] = {{fan.normal_x[in_fan], fan.normal_y[in_fan], fan.normal_z[in_fan]}, fan.offset[in_fan]};
  heights_[at(f)] = fan.height[in_fan];
  if (!std::isfinite(heights_[at(f)])) planes_[at(f)] = {}, heights_[at(f)] = kNoHeight;
}

void ExpandingPolytope::link(std::int32_t f, std::size_t edge, std::int32_t other, std::size_t other_edge) {
  faces_[at(f)].across[edge] = other, faces_[at(f)].across_edge[edge] = static_cast<std::int8_t>(other_edge);
  faces_[at(other)].across[other_edge] = f, faces_[at(other)].across_edge[other_edge] = static_cast<std::int8_t>(edge);
}

}  // namespace plannercheck
