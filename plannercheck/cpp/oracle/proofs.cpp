#include "oracle/proofs.hpp"

#include <algorithm>
#include <utility>

namespace plannercheck::oracle {
namespace {

// The distance falls strictly, so the search ends; random bodies take about six steps.
constexpr int kMostSteps = 10'000;

struct Difference {
  std::size_t first, second;
  Vector point;
};

// Differences, the weights that mix the point of their hull nearest to the origin, and a direction towards it.
struct Face {
  std::vector<Difference> corners;
  std::vector<Integer> weights;
  Vector direction;  // 0 if that is the origin
};

Vector signed_as(const Integer& sign, Vector v) { return sign.sign() == 0 ? Vector{} : sign.sign() > 0 ? v : -v; }

// Projects the origin on the affine span of the corners; their weights have to be positive.
void project(Face& face) {
  const auto& c = face.corners;
  const Vector& a = c[0].point;
  if (c.size() == 1) {
    face.weights = {Integer(1)}, face.direction = a;
  } else if (c.size() == 2) {
    const Vector &b = c[1].point, edge = b - a;
    face.weights = {dot(edge, b), -dot(edge, a)};
    face.direction = face.weights[0] * a + face.weights[1] * b;
  } else if (c.size() == 3) {
    const Vector &b = c[1].point, &d = c[2].point, normal = cross(b - a, d - a);
    face.weights = {dot(normal, cross(b, d)), dot(normal, cross(d, a)), dot(normal, cross(a, b))};
    face.direction = signed_as(dot(normal, a), normal);
  } else {
    const Vector &b = c[1].point, &d = c[2].point, &e = c[3].point;
    const Vector bd = cross(b, d), ea = cross(e, a);
    face.weights = {dot(bd, e), -dot(cross(d, e), a), dot(ea, b), -dot(bd, a)};
    if (face.weights[0].sign() < 0) {
      for (Integer& w : face.weights) w = -w;
    }
    face.direction = {};
  }
}

bool is_inside(const Face& face) {
  return std::all_of(face.weights.begin(), face.weights.end(), [](const Integer& w) { return w.sign() > 0; });
}

// Whether no corner of the simplex is nearer along the face's direction than the face.
bool supports(const Face& face, const std::vector<Difference>& simplex) {
  const Integer height = dot(face.direction, face.corners[0].point);
  return std::all_of(simplex.begin(), simplex.end(),
                     [&](const Difference& d) { return dot(face.direction, d.point) >= height; });
}

// Among the simplex's faces with its last corner, the one that holds the point nearest to the origin.
Face nearest_face(const std::vector<Difference>& simplex) {
  const unsigned newest = 1U << (simplex.size() - 1);
  for (int size = static_cast<int>(simplex.size()) - 1; size >= 0; --size) {
    for (unsigned others = 0; others < newest; ++others) {
      if (__builtin_popcount(others) != size) continue;
      Face face;
      for (std::size_t i = 0; i < simplex.size(); ++i) {
        if (((others | newest) >> i & 1U) != 0) face.corners.push_back(simplex[i]);
      }
      project(face);
      if (is_inside(face) && supports(face, simplex)) return face;
    }
  }
  return {};
}

Difference difference_of(const Pair& pair, std::size_t first, std::size_t second) {
  return {first, second, pair.p.point(first) - pair.r.point(second)};
}

Difference furthest_against(const Pair& pair, const Vector& direction, bool every) {
  return difference_of(pair, pair.p.lowest(direction, every), pair.r.lowest(-direction, every));
}

// Whether a height along a direction exceeds `length` times the direction's length.
bool exceeds(const Integer& height, const Vector& direction, const Integer& length) {
  return height.sign() > 0 && height * height > (length * length) * dot(direction, direction);
}

Mixture mixture_of(const Face& face) {
  Mixture out;
  for (const Difference& d : face.corners) out.first.push_back(d.first), out.second.push_back(d.second);
  out.weights = face.weights;
  return out;
}

}  // namespace

Pair::Pair(PosedPoints first, PosedPoints second) : p(std::move(first)), r(std::move(second)) {
  const int unit = std::min(p.unit(), r.unit());
  p.use_unit(unit), r.use_unit(unit);
}

bool proves_apart(const Pair& pair, const Vector& direction, bool every) {
  const Difference least = furthest_against(pair, direction, every);
  return exceeds(dot(direction, least.point), direction, pair.p.inflation_radius() + pair.r.inflation_radius());
}

bool proves_shared(const Pair& pair, const Mixture& mixture) {
  Vector apart;
  Integer mass;
  const std::size_t count = mixture.weights.size();
  if (mixture.first.size() != count || mixture.second.size() != count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (mixture.first[i] >= pair.p.count() || mixture.second[i] >= pair.r.count()) return false;
    if (mixture.weights[i].sign() < 0) return false;
    apart = apart + mixture.weights[i] * difference_of(pair, mixture.first[i], mixture.second[i]).point;
    mass = mass + mixture.weights[i];
  }
  const Integer within = (pair.p.inflation_radius() + pair.r.inflation_radius()) * mass;
  return mass.sign() > 0 && dot(apart, apart) <= within * within;
}

Proof prove(const Pair& pair, bool every) {
  const Integer inflation_radius = pair.p.inflation_radius() + pair.r.inflation_radius();
  std::vector<Difference> simplex{difference_of(pair, 0, 0)};
  for (int step = 0; step < kMostSteps; ++step) {
    Face face = nearest_face(simplex);
    if (face.corners.empty()) return {};
    if (is_zero(face.direction) ||
        !exceeds(dot(face.direction, face.corners[0].point), face.direction, inflation_radius)) {
      Mixture mixture = mixture_of(face);
      if (!proves_shared(pair, mixture)) return {};
      return {Proof::Kind::kShared, {}, std::move(mixture)};
    }
    if (proves_apart(pair, face.direction, every)) return {Proof::Kind::kApart, std::move(face.direction), {}};
    Difference furthest = furthest_against(pair, face.direction, false);
    simplex = std::move(face.corners);
    simplex.push_back(std::move(furthest));
  }
  return {};
}

}  // namespace plannercheck::oracle
