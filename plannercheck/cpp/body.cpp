#include "body.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "double2.hpp"
#include "dyadic.hpp"
#include "flat_hull.hpp"
#include "predicates.hpp"

namespace plannercheck {
namespace {

constexpr double kRoundUp = 1 + 0x1p-48;  // covers the rounding of a norm

// n / (n · (a − centre)) for the plane through a, b, c: double-double where its error stays below 2^-60, else exact.
Vec3 polar_point(Vec3 centre, Vec3 a, Vec3 b, Vec3 c) {
  const Double2Vec3 n = cross(difference(b, a), difference(c, a));
  const Double2 height = dot(n, difference(a, centre));
  const double size = norm_max(b - a) * norm_max(c - a);
  const double length = larger(std::fabs(n.x.high), larger(std::fabs(n.y.high), std::fabs(n.z.high)));
  const bool precise = size > 1e-150 && size < 1e60 && size * 0x1p-96 < length * 0x1p-62 &&
                       size * norm_max(a - centre) * 0x1p-94 < height.high * 0x1p-62;
  if (precise) return {n.x.high / height.high, n.y.high / height.high, n.z.high / height.high};
  const DyadicVec3 corner(a);
  const DyadicVec3 normal = cross(DyadicVec3(b) - corner, DyadicVec3(c) - corner);
  const Dyadic exact_height = dot(normal, corner - DyadicVec3(centre));
  const std::int64_t scale = -exact_height.log2();
  const double divisor = exact_height.to_double(scale);
  return {normal.x.to_double(scale) / divisor, normal.y.to_double(scale) / divisor,
          normal.z.to_double(scale) / divisor};
}

double squared_area(const ConvexMesh& mesh, const Triangle& t) {
  const Vec3 a = mesh.vertices[at(t[0])];
  const Vec3 n = cross(mesh.vertices[at(t[1])] - a, mesh.vertices[at(t[2])] - a);
  return dot(n, n);
}

// One point a facet, from its largest triangle.
std::vector<Vec3> polar_points(const ConvexMesh& mesh, Vec3 centre) {
  int count = 0;
  const std::vector<int> facet = facets(mesh, &count);
  std::vector<int> largest(at(count), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    int& best = largest[at(facet[t])];
    if (best < 0 || squared_area(mesh, mesh.triangles[t]) > squared_area(mesh, mesh.triangles[at(best)])) {
      best = static_cast<int>(t);
    }
  }
  std::vector<Vec3> points;
  for (const int t : largest) {
    const Triangle& v = mesh.triangles[at(t)];
    points.push_back(polar_point(centre, mesh.vertices[at(v[0])], mesh.vertices[at(v[1])], mesh.vertices[at(v[2])]));
  }
  return points;
}

double largest_norm(const std::vector<Vec3>& points, Vec3 from) {
  double largest = 0;
  for (const Vec3& p : points) largest = larger(largest, norm(p - from));
  return largest * kRoundUp;
}

// `points`: the vertices, which differ.
void enclose(Body& body, const std::vector<Vec3>& points) {
  body.low = body.high = points.front();
  for (const Vec3& p : points) {
    body.low = {smaller(body.low.x, p.x), smaller(body.low.y, p.y), smaller(body.low.z, p.z)};
    body.high = {larger(body.high.x, p.x), larger(body.high.y, p.y), larger(body.high.z, p.z)};
  }
  const auto at_corner = [&](const Vec3& p) {
    return (p.x == body.low.x || p.x == body.high.x) && (p.y == body.low.y || p.y == body.high.y) &&
           (p.z == body.low.z || p.z == body.high.z);
  };
  body.is_box = points.size() == 8 && std::all_of(points.begin(), points.end(), at_corner) ? 1 : 0;
}

class Writer {
 public:
  template <class T>
  void value(const T& v) {
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  template <class T>
  void array(const std::vector<T>& v) {
    value(static_cast<std::uint64_t>(v.size()));
    bytes_.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T));
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(const char* data, std::size_t size) : data_(data), left_(size) {}
  template <class T>
  void value(T& v) {
    take(&v, sizeof v);
  }
  template <class T>
  void array(std::vector<T>& v) {
    std::uint64_t count = 0;
    value(count);
    if (count > left_ / sizeof(T)) throw HullError("the data end early");
    v.resize(count);
    take(v.data(), count * sizeof(T));
  }
  bool done() const { return left_ == 0; }

 private:
  const char* data_;
  std::size_t left_;

  void take(void* to, std::size_t size) {
    if (size > left_) throw HullError("the data end early");
    if (size > 0) std::memcpy(to, data_, size);
    data_ += size;
    left_ -= size;
  }
};

// The fields in the order of the format, once for reading and writing.
template <class Stream, class H>
void each_level_field(Stream& s, H& h) {
  s.array(h.points), s.array(h.level), s.value(h.depth), s.array(h.ring_start), s.array(h.rings), s.array(h.top);
  s.array(h.top_blocks), s.array(h.all_blocks), s.array(h.chains), s.array(h.blocks), s.array(h.fan_of);
  s.array(h.fans), s.array(h.wedges), s.array(h.entries), s.value(h.largest_coordinate);
}

template <class Stream, class H>
void each_field(Stream& s, H& h) {
  each_level_field(s, h);
  each_level_field(s, h.crown);
}

template <class Stream, class B>
void each_body_field(Stream& s, B& b) {
  s.value(b.dimension), s.value(b.swell), s.array(b.triangles), s.array(b.source), s.value(b.centre), s.value(b.reach),
      s.value(b.radius), s.value(b.low), s.value(b.high), s.value(b.is_box);
  each_field(s, b.inner);
  each_field(s, b.polar);
  s.array(b.polar_triangles);
  s.value(b.polar_radius), s.value(b.facet_count);
}

void require(bool sound) {
  if (!sound) throw HullError("the data are damaged");
}

bool is_below(std::int32_t index, std::size_t end) { return index >= 0 && at(index) < end; }

bool is_below_or_none(std::int32_t index, std::size_t end) { return index == -1 || is_below(index, end); }

bool all_below(const std::vector<std::int32_t>& indices, std::size_t end) {
  return std::all_of(indices.begin(), indices.end(), [&](std::int32_t i) { return is_below(i, end); });
}

bool all_corners_below(const std::vector<Triangle>& triangles, std::size_t end) {
  return std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](int i) { return is_below(i, end); });
  });
}

bool within(std::int32_t first, std::int32_t count, std::size_t end) {
  return first >= 0 && count >= 0 && at(first) + at(count) <= end;
}

void require_sound_wedge(const Levels& h, std::size_t w) {
  const WedgeNode& node = h.wedges[w];
  const std::size_t n = h.points.size();
  require(is_below(node.rim, n) && is_below_or_none(node.left, n) && is_below_or_none(node.right, n));
  for (const std::int32_t next : {node.next_left, node.next, node.next_right}) {
    require(is_below_or_none(next, h.wedges.size()) && (next < 0 || at(next) > w));
  }
  require((node.left < 0) == (node.next_left < 0) && (node.right < 0) == (node.next_right < 0));
  require(node.next >= 0 || node.left >= 0 || node.right < 0);
}

// Every index that a query follows stays in its array, and wedges lead on to later ones only: damaged data may give
// wrong answers, but no query leaves memory or runs forever.
void require_sound_levels(const Levels& h) {
  const std::size_t n = h.points.size(), top = h.top.size();
  for (const Vec3& p : h.points) require(std::isfinite(norm_1(p)));
  require(n >= 1 && h.level.size() == n && h.chains.size() == n && h.fan_of.size() == n && h.depth >= 0);
  require(h.ring_start.size() == n + 1 && h.ring_start.front() == 0 && at(h.ring_start.back()) == h.rings.size());
  require(std::is_sorted(h.ring_start.begin(), h.ring_start.end()) && all_below(h.rings, n));
  require(top > 0 && top <= kUnlayered && top == h.top_blocks.size() * kScanLanes && all_below(h.top, n));
  const std::size_t scanned = (n + kScanLanes - 1) / kScanLanes;
  require(h.all_blocks.empty() || (h.all_blocks.size() == scanned && n <= kScannedVertices));
  for (const ChainRange& c : h.chains) {
    require(c.length >= 0 &&
            within(c.first_block, c.length / kBlockLanes + (c.length % kBlockLanes != 0), h.blocks.size()));
  }
  for (const Block& block : h.blocks) {
    for (const std::int32_t v : block.vertex) require(is_below(v, n));
  }
  require(all_below(h.entries, h.wedges.size()));
  for (const std::int32_t fan : h.fan_of) require(is_below_or_none(fan, h.fans.size()));
  for (const WedgeFan& fan : h.fans) {
    require(fan.entries > 0 && within(fan.first_entry, fan.entries, h.entries.size()));
    require(fan.first_half >= 1 && fan.first_half <= fan.entries);
  }
  for (std::size_t w = 0; w < h.wedges.size(); ++w) require_sound_wedge(h, w);
}

void require_sound_indices(const Hierarchy& h) {
  require_sound_levels(h);
  require_sound_levels(h.crown);
  require(std::is_sorted(h.top.begin(), h.top.end()) && h.crown.points.size() <= h.top.size());
  for (std::size_t v = 0; v < h.points.size(); ++v) {
    if (h.level[v] != h.depth) continue;
    const auto place = std::lower_bound(h.top.begin(), h.top.end(), static_cast<std::int32_t>(v));
    require(at(static_cast<std::int32_t>(place - h.top.begin())) < h.crown.points.size());
  }
}

}  // namespace

namespace {

// The polar about a point strictly inside. False, and nothing changed, if doubles can't hold it: the body is thinner
// than their grid, or so small that its polar overflows.
bool add_polar(const ConvexMesh& mesh, Body& body) try {
  const std::optional<Vec3> inside = interior_point(mesh);
  if (!inside) return false;
  const std::vector<Vec3> points = polar_points(mesh, *inside);
  const double radius = largest_norm(points, {});
  if (!std::isfinite(radius)) return false;
  const ConvexMesh polar = convex_hull(points);
  body.centre = *inside;
  body.polar_radius = radius;
  body.polar_triangles = polar.triangles;
  body.polar = build_hierarchy(polar);
  return true;
} catch (const HullError&) {
  return false;
}

// Without a polar the centre only aims and bounds: the mean of the vertices will do, rounded.
void do_without_polar(Body& body) {
  const std::vector<Vec3>& vertices = body.inner.points;
  const double weight = 1 / static_cast<double>(vertices.size());
  body.centre = {};
  for (const Vec3& v : vertices) body.centre = body.centre + weight * v;
  body.polar_radius = std::numeric_limits<double>::infinity();
}

void measure(Body& body) {
  body.reach = largest_norm(body.inner.points, {});
  body.radius = largest_norm(body.inner.points, body.centre);
  enclose(body, body.inner.points);
}

}  // namespace

Body prepare_body(const ConvexMesh& mesh) {
  Body body;
  body.triangles = mesh.triangles;
  body.source = mesh.source;
  body.inner = build_hierarchy(mesh);
  facets(mesh, &body.facet_count);
  if (!add_polar(mesh, body)) do_without_polar(body);
  measure(body);
  return body;
}

Body prepare_body(const std::vector<Vec3>& points) {
  const Span span = affine_span(points);
  if (span.dimension == 3) return prepare_body(convex_hull(points));
  const FlatHull hull = flat_hull(points, span);
  Body body;
  body.dimension = hull.dimension;
  body.source = hull.source;
  body.inner = build_flat_hierarchy(hull);
  do_without_polar(body);
  measure(body);
  return body;
}

namespace {

// Every vertex of a flat body is a corner: it is further out than its neighbours allow.
std::string flat_fault(const Body& body) {
  const FlatHull again = flat_hull(body.inner.points, affine_span(body.inner.points));
  if (again.dimension != body.dimension) return "the dimension is wrong";
  if (again.vertices.size() != body.inner.points.size()) return "a vertex is no corner";
  for (const Levels* h : {static_cast<const Levels*>(&body.inner), &body.inner.crown}) {
    std::size_t chained = 0;
    for (const ChainRange& chain : h->chains) chained += at(chain.length);
    const auto removed = std::count_if(h->level.begin(), h->level.end(), [&](auto l) { return l < h->depth; });
    if (chained != 2 * static_cast<std::size_t>(removed)) return "the chains are incomplete";
  }
  return {};
}

}  // namespace

std::string body_fault(const Body& body) try {
  if (body.dimension < 3) return flat_fault(body);
  const ConvexMesh hull = verified_hull(body.inner.points, body.triangles, &body.centre);
  const std::string inner = hierarchy_fault(hull, body.inner);
  if (!inner.empty()) return "hull: " + inner;
  if (!body.has_polar()) return {};
  const Vec3 origin;
  const ConvexMesh dual = verified_hull(body.polar.points, body.polar_triangles, &origin);
  const std::string polar = hierarchy_fault(dual, body.polar);
  if (!polar.empty()) return "polar: " + polar;
  for (const Triangle& t : body.triangles) {
    const auto& p = body.inner.points;
    if (orientation(p[at(t[0])], p[at(t[1])], p[at(t[2])], body.centre) >= 0)
      return "the centre is not strictly inside";
  }
  return {};
} catch (const HullError& error) {
  return error.what();
}

std::size_t Body::bytes() const {
  return sizeof *this + triangles.size() * sizeof(Triangle) + source.size() * sizeof(source[0]) + inner.bytes() +
         inner.crown.bytes() + polar.bytes() + polar.crown.bytes() + polar_triangles.size() * sizeof(Triangle);
}

std::string serialise(const Body& body) {
  Writer writer;
  each_body_field(writer, body);
  return writer.take();
}

Body parse_body(const char* data, std::size_t size) {
  Body body;
  Reader reader(data, size);
  each_body_field(reader, body);
  if (!reader.done()) throw HullError("the data go on after the end");
  require(body.dimension >= 0 && body.dimension <= 3 && body.swell >= 0 && std::isfinite(body.swell));
  require(body.is_box == 0 || (body.is_box == 1 && body.inner.points.size() == 8));
  require_sound_indices(body.inner);
  if (body.has_polar()) require_sound_indices(body.polar);
  require(body.source.size() == body.inner.points.size() &&
          all_corners_below(body.triangles, body.inner.points.size()));
  require(all_corners_below(body.polar_triangles, body.polar.points.size()));
  return body;
}

}  // namespace plannercheck
