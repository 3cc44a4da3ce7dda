// Signed distances of two posed convex bodies in 113 bits, by brute force.
//
// In: vertices, triangles and edges of two bodies, and their poses, as doubles. Out: the signed distance of each pair,
// as a sum of two doubles. It shares nothing with the code that it judges. Bodies apart: nearest points by all subsets
// of corners (Gilbert, Johnson and Keerthi 1988), all vertices asked for each. Bodies that overlap: the least overlap
// along the normals of all triangles, and along the products of all pairs of edges whose arcs on the Gauss map may
// cross, and along the axes. More directions than needed do no harm, since no overlap is less than the depth.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace {

using Real = __float128;

struct Vec {
  Real x = 0, y = 0, z = 0;
};
Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator*(Real s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
Real dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

Real root(Real x) {
  if (!(x > 0)) return 0;
  Real r = std::sqrt(static_cast<long double>(x));
  for (int k = 0; k < 2; ++k) r = (r + x / r) / 2;
  return r;
}

struct Rough {
  double x = 0, y = 0, z = 0;
};
Rough rough(Vec a) { return {static_cast<double>(a.x), static_cast<double>(a.y), static_cast<double>(a.z)}; }
double dot(Rough a, Rough b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Rough operator-(Rough a) { return {-a.x, -a.y, -a.z}; }
Rough cross(Rough a, Rough b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Rough unit(Rough a) {
  const double length = std::sqrt(dot(a, a));
  return length > 0 ? Rough{a.x / length, a.y / length, a.z / length} : a;
}

struct Edge {
  std::int32_t from, to, left, right;  // triangles on both sides; −1: none, its arc is unknown
};

struct Body {
  const double* vertices;
  std::int32_t count;
  const std::int32_t* triangles;
  std::int32_t triangle_count;
  const Edge* edges;
  std::int32_t edge_count;
};

struct Posed {
  const Body& body;
  std::vector<Vec> at;
  std::vector<Rough> near;
  std::vector<Rough> normals;

  Posed(const Body& given, const double* pose) : body(given) {
    for (std::int32_t i = 0; i < given.count; ++i) {
      const double* v = given.vertices + 3 * i;
      std::array<Real, 3> out;
      for (std::size_t k = 0; k < 3; ++k) {
        const double* row = pose + 4 * k;
        out[k] = static_cast<Real>(row[0]) * v[0] + static_cast<Real>(row[1]) * v[1] + static_cast<Real>(row[2]) * v[2] +
                 row[3];
      }
      at.push_back({out[0], out[1], out[2]});
      near.push_back(rough(at.back()));
    }
    for (std::int32_t t = 0; t < given.triangle_count; ++t) normals.push_back(unit(rough(normal(t))));
  }

  Vec normal(std::int32_t t) const {
    const std::int32_t* c = body.triangles + 3 * t;
    return cross(at[c[1]] - at[c[0]], at[c[2]] - at[c[0]]);
  }
  Vec along(const Edge& e) const { return at[e.to] - at[e.from]; }

  // The vertex furthest along a direction: by doubles, and in 113 bits among those that doubles do not tell apart.
  std::int32_t furthest(Vec d) const {
    const Rough u = rough(d);
    const double size = std::fabs(u.x) + std::fabs(u.y) + std::fabs(u.z);
    double best = -1e300, largest = 0;
    for (const Rough& v : near) {
      best = std::max(best, dot(u, v));
      largest = std::max({largest, std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    }
    const double tie = 1e-14 * size * largest;
    std::int32_t found = -1;
    Real height = 0;
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (dot(u, near[i]) < best - tie) continue;
      const Real h = dot(d, at[i]);
      if (found < 0 || h > height) found = static_cast<std::int32_t>(i), height = h;
    }
    return found;
  }
  double rough_furthest(Rough u) const {
    double best = -1e300;
    for (const Rough& v : near) best = std::max(best, dot(u, v));
    return best;
  }
};

// How far a translation along the outward normal d of A − B has to go, in units of |d|.
Real overlap(const Posed& a, const Posed& b, Vec d) {
  const Vec back = Real(-1) * d;
  return dot(d, a.at[a.furthest(d)] - b.at[b.furthest(back)]);
}

// Weights of the origin's projection on the span of up to four corners, if all are positive.
bool projected(const std::vector<Vec>& p, std::vector<Real>& w) {
  const std::size_t n = p.size();
  if (n == 1) return w = {1}, true;
  if (n == 2) {
    const Vec e = p[1] - p[0];
    w = {dot(p[1], e), -dot(p[0], e)};
  } else if (n == 3) {
    const Vec m = cross(p[1] - p[0], p[2] - p[0]);
    w = {dot(m, cross(p[1], p[2])), dot(m, cross(p[2], p[0])), dot(m, cross(p[0], p[1]))};
  } else {
    w = {dot(p[1], cross(p[2], p[3])), -dot(p[0], cross(p[2], p[3])), dot(p[0], cross(p[1], p[3])),
         -dot(p[0], cross(p[1], p[2]))};
    if (w[0] < 0) {
      for (Real& x : w) x = -x;
    }
  }
  Real sum = 0;
  for (const Real x : w) {
    if (!(x > 0)) return false;
    sum += x;
  }
  for (Real& x : w) x /= sum;
  return true;
}

// The distance of two bodies; 0 if it is below 1e-28 of their size, negative if rounding leaves it open.
Real distance(const Posed& a, const Posed& b, Real size) {
  std::vector<Vec> simplex;
  Vec v = a.at[0] - b.at[0];
  simplex.push_back(v);
  Real square = dot(v, v);
  for (int round = 0; round < 500; ++round) {
    if (square <= size * size * Real(1e-56)) return 0;
    const Vec back = Real(-1) * v;
    const Vec w = a.at[a.furthest(back)] - b.at[b.furthest(v)];
    if (square - dot(v, w) <= root(square) * size * Real(1e-30)) return root(square);
    simplex.push_back(w);
    std::vector<Vec> best;
    Real least = square;
    Vec nearest = v;
    for (unsigned chosen = 1; chosen < 1U << simplex.size(); ++chosen) {
      std::vector<Vec> face;
      std::vector<Real> weight;
      for (std::size_t i = 0; i < simplex.size(); ++i) {
        if (chosen >> i & 1U) face.push_back(simplex[i]);
      }
      if (!projected(face, weight)) continue;
      Vec sum;
      for (std::size_t i = 0; i < face.size(); ++i) sum = sum + weight[i] * face[i];
      if (face.size() == 4) return 0;
      if (dot(sum, sum) < least) best = face, least = dot(sum, sum), nearest = sum;
    }
    if (best.empty()) return -1;
    simplex = best, square = least, v = nearest;
  }
  return -1;
}

struct Candidate {
  double overlap;
  Vec direction;
};

class Depth {
 public:
  Depth(const Posed& a, const Posed& b) : a_(a), b_(b) {}

  Real run() {
    for (const Vec axis : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}}) both(axis);
    for (const Posed* posed : {&a_, &b_}) {
      for (std::int32_t t = 0; t < posed->body.triangle_count; ++t) both(posed->normal(t));
      if (posed->body.triangle_count > 0) continue;
      for (std::int32_t e = 0; e < posed->body.edge_count; ++e) {
        for (const Vec axis : {Vec{1, 0, 0}, Vec{0, 1, 0}, Vec{0, 0, 1}})
          both(cross(axis, posed->along(posed->body.edges[e])));
      }
    }
    for (std::int32_t i = 0; i < a_.body.edge_count; ++i) {
      for (std::int32_t j = 0; j < b_.body.edge_count; ++j) {
        const Edge &e = a_.body.edges[i], &f = b_.body.edges[j];
        if (may_cross(e, f)) both(cross(a_.along(e), b_.along(f)));
      }
    }
    Real least = 1e300;
    for (const Candidate& c : candidates_) {
      if (c.overlap > best_ + 1e-9 * (1 + best_)) continue;
      least = std::min(least, overlap(a_, b_, c.direction) / root(dot(c.direction, c.direction)));
    }
    return least;
  }

 private:
  const Posed &a_, &b_;
  std::vector<Candidate> candidates_;
  double best_ = 1e300;

  void both(Vec d) {
    const Rough u = unit(rough(d));
    if (!(dot(u, u) > 0.5)) return;
    one(d, u), one(Real(-1) * d, -u);
  }
  void one(Vec d, Rough u) {
    const double along = a_.rough_furthest(u) + b_.rough_furthest(-u);
    best_ = std::min(best_, along);
    if (along <= best_ + 1e-9 * (1 + std::fabs(best_))) candidates_.push_back({along, d});
  }

  // Whether the arcs of two edges, one turned round, may cross on the sphere; where doubles do not tell, they may.
  bool may_cross(const Edge& e, const Edge& f) const {
    if (e.left < 0 || f.left < 0) return true;
    const Rough a = a_.normals[e.left], b = a_.normals[e.right], c = -b_.normals[f.left], d = -b_.normals[f.right];
    const Rough ba = cross(b, a), dc = cross(d, c);
    const double cba = dot(c, ba), dba = dot(d, ba), adc = dot(a, dc), bdc = dot(b, dc);
    const double tie = 1e-12;
    const auto surely_same = [&](double x, double y) { return std::min(std::fabs(x), std::fabs(y)) > tie && x * y > 0; };
    if (surely_same(cba, dba) || surely_same(adc, bdc)) return false;
    return !surely_same(cba, -bdc);
  }
};

}  // namespace

// `overlap`: whether it is known that the hulls share a point. NaN where rounding leaves the distance open.
extern "C" void signed_distances(const Body* first, const Body* second, std::int64_t pairs, const double* poses_a,
                                 const double* poses_b, const double* radii, bool overlap, double* high, double* low) {
  for (std::int64_t i = 0; i < pairs; ++i) {
    const Posed a(*first, poses_a + 16 * i), b(*second, poses_b + 16 * i);
    double size = 0;
    for (const Posed* posed : {&a, &b}) {
      for (const Rough& v : posed->near) size = std::max({size, std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    }
    const Real apart = overlap ? Real(0) : distance(a, b, size);
    if (apart < 0) {
      high[i] = low[i] = std::nan("");
      continue;
    }
    const Real found = (apart > 0 ? apart : -std::max(Depth(a, b).run(), Real(0))) - radii[0] - radii[1];
    high[i] = static_cast<double>(found);
    low[i] = static_cast<double>(found - high[i]);
  }
}
