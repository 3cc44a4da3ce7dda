#include "narrow_phase/triangle_pair.hpp"

#include "math/predicates.hpp"

namespace plannercheck {
namespace {

// The error of a volume det(b − a, c − a, d − a). The given coordinates are within e of the exact ones, differences are
// at most L in size: a difference errs by r = 2e + uL, so that a product of three errs by 3L²r (1 + r/L)², six of them
// by 18 L² r = 36 L² e + 18u L³ up to a part in a million; multiplying and adding up rounds six products of L³ at most
// six times each, 36u L³.
constexpr double kVolumeOfError = 40, kVolumeOfRounding = 64 * kRoundoff;

// Below and above these sizes products of three underflow or overflow.
constexpr double kLeastSpread = 1e-90, kLargestSpread = 1e90;

// Signs of volumes: 1, −1, or 0 if rounding leaves it open.
class Signs {
 public:
  Signs(const TriangleCorners& a, const TriangleCorners& b, double error) {
    double spread = 0;
    for (int axis = 0; axis < 3; ++axis) {
      double low = a[0][axis], high = low;
      for (const TriangleCorners* corners : {&a, &b}) {
        for (const Vec3& corner : *corners) low = smaller(low, corner[axis]), high = larger(high, corner[axis]);
      }
      spread = larger(spread, high - low);
    }
    is_trusted_ = are_volumes_trusted(spread, error);
    bound_ = volume_bound(spread, error);
  }

  bool are_trusted() const { return is_trusted_; }
  int operator()(double volume) const { return volume > bound_ ? 1 : volume < -bound_ ? -1 : 0; }

 private:
  bool is_trusted_;
  double bound_;
};

struct Sides {
  std::array<int, 3> sign;

  bool all_on_one() const { return sign[0] != 0 && sign[0] == sign[1] && sign[1] == sign[2]; }
};

// On which sides of a triangle's plane the other one's corners are.
Sides sides_of(const TriangleCorners& plane, const TriangleCorners& corners, const Signs& sign) {
  const Vec3 normal = cross(plane[1] - plane[0], plane[2] - plane[0]);
  return {{sign(dot(normal, corners[0] - plane[0])), sign(dot(normal, corners[1] - plane[0])),
           sign(dot(normal, corners[2] - plane[0]))}};
}

// How the line through p and q, from one side of the triangle to the other, passes it.
TriangleAnswer passes(Vec3 p, Vec3 q, const TriangleCorners& t, const Signs& sign) {
  const Vec3 way = q - p, a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const std::array<int, 3> turns{sign(dot(way, cross(a, b))), sign(dot(way, cross(b, c))), sign(dot(way, cross(c, a)))};
  bool left = false, right = false, open = false;
  for (const int turn : turns) left |= turn > 0, right |= turn < 0, open |= turn == 0;
  if (left && right) return TriangleAnswer::kApart;
  return open ? TriangleAnswer::kOpen : TriangleAnswer::kMeet;
}

// Whether an edge of one triangle meets the other one; `sides`: those of the first one's corners.
TriangleAnswer edges_meet(const TriangleCorners& edges, const Sides& sides, const TriangleCorners& t,
                          const Signs& sign) {
  TriangleAnswer answer = TriangleAnswer::kApart;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = k == 2 ? 0 : k + 1;
    const int from = sides.sign[k], to = sides.sign[next];
    if (from != 0 && from == to) continue;
    const TriangleAnswer one = passes(edges[k], edges[next], t, sign);
    if (one == TriangleAnswer::kApart) continue;
    if (one == TriangleAnswer::kMeet && from != 0 && to != 0) return TriangleAnswer::kMeet;
    answer = TriangleAnswer::kOpen;
  }
  return answer;
}

}  // namespace

bool are_volumes_trusted(double spread, double error) {
  return spread > kLeastSpread && spread < kLargestSpread && error < spread * 0x1p-24;
}

double volume_bound(double spread, double error) {
  return spread * spread * (kVolumeOfError * error + kVolumeOfRounding * spread);
}

TriangleAnswer triangles_meet(const TriangleCorners& a, const TriangleCorners& b, double error) {
  const Signs sign(a, b, error);
  if (!sign.are_trusted()) return TriangleAnswer::kOpen;
  const Sides of_a = sides_of(b, a, sign);
  if (of_a.all_on_one()) return TriangleAnswer::kApart;
  const Sides of_b = sides_of(a, b, sign);
  if (of_b.all_on_one()) return TriangleAnswer::kApart;
  const TriangleAnswer by_a = edges_meet(a, of_a, b, sign);
  if (by_a == TriangleAnswer::kMeet) return by_a;
  const TriangleAnswer by_b = edges_meet(b, of_b, a, sign);
  return by_b == TriangleAnswer::kApart ? by_a : by_b;
}

}  // namespace plannercheck
