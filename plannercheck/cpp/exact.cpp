#include "exact.hpp"

#include <vector>

#include "predicates.hpp"

namespace plannercheck {
namespace {

// Mᵀ d, exactly.
DyadicVec3 rotate_back_exactly(const Pose& pose, const DyadicVec3& d) {
  const auto column = [&](std::size_t j) {
    return Dyadic(pose.m[j]) * d.x + Dyadic(pose.m[j + 4]) * d.y + Dyadic(pose.m[j + 8]) * d.z;
  };
  return {column(0), column(1), column(2)};
}

// Compares points along an exact direction: doubles first, dyadic numbers where they can't tell.
class ExactComparison {
 public:
  explicit ExactComparison(const DyadicVec3& u) : exact_(u), rounded_(direction_of(u)) {}

  // Sign of u · (a − b).
  int sign(Vec3 a, Vec3 b) const {
    const Vec3 e = a - b;
    const double value = dot(rounded_, e);
    // The rounded direction errs by 2u an entry (entries at most 1), the difference, products and sums by 4u.
    if (std::fabs(value) > 8 * kRoundoff * norm_1(e) + 1e-290) return value > 0 ? 1 : -1;
    return dot(exact_, DyadicVec3(a) - DyadicVec3(b)).sign();
  }

 private:
  const DyadicVec3& exact_;
  Vec3 rounded_;
};

struct Corner {
  std::int32_t guest, host;
  DyadicVec3 point;  // guest vertex − host vertex in the world
};

struct Nearest {
  std::vector<Corner> corners;  // the smallest set whose hull holds the nearest point, inside
  std::vector<Dyadic> weights;
  DyadicVec3 direction;  // towards the nearest point; 0 if that is the origin
};

bool is_zero(const DyadicVec3& v) { return v.x.sign() == 0 && v.y.sign() == 0 && v.z.sign() == 0; }

// Candidates for the nearest point: the projection of the origin on the hull of some corners, if it lies inside it.
class Candidate {
 public:
  explicit Candidate(const std::vector<Corner>& corners) : corners_(corners) {}

  bool try_point(std::size_t a) {
    found_ = {{corners_[a]}, {Dyadic(1.0)}, corners_[a].point};
    return is_nearest();
  }

  bool try_segment(std::size_t ia, std::size_t ib) {
    const DyadicVec3 &a = corners_[ia].point, &b = corners_[ib].point;
    const DyadicVec3 e = b - a;
    const Dyadic length = dot(e, e), along = -dot(a, e), rest = length - along;
    if (along.sign() <= 0 || rest.sign() <= 0) return false;
    found_ = {{corners_[ia], corners_[ib]}, {rest, along}, rest * a + along * b};
    return is_nearest();
  }

  bool try_triangle(std::size_t ia, std::size_t ib, std::size_t ic) {
    const DyadicVec3 &a = corners_[ia].point, &b = corners_[ib].point, &c = corners_[ic].point;
    const DyadicVec3 n = cross(b - a, c - a);
    if (is_zero(n)) return false;
    const std::vector<Dyadic> weights{dot(n, cross(b, c)), dot(n, cross(c, a)), dot(n, cross(a, b))};
    for (const Dyadic& w : weights) {
      if (w.sign() <= 0) return false;
    }
    const int side = dot(n, a).sign();
    found_ = {{corners_[ia], corners_[ib], corners_[ic]}, weights, Dyadic(static_cast<double>(side)) * n};
    return is_nearest();
  }

  // The four corners hold the origin inside.
  void take_tetrahedron() {
    const DyadicVec3 &a = corners_[0].point, &b = corners_[1].point, &c = corners_[2].point, &d = corners_[3].point;
    found_.corners = corners_;
    found_.weights = {dot(b, cross(c, d)), -dot(a, cross(c, d)), dot(a, cross(b, d)), -dot(a, cross(b, c))};
    if (found_.weights[0].sign() < 0) {
      for (Dyadic& w : found_.weights) w = -w;
    }
    found_.direction = {};
  }

  const Nearest& found() const { return found_; }

 private:
  const std::vector<Corner>& corners_;
  Nearest found_;

  // No corner is nearer along the direction (which is then that of the nearest point).
  bool is_nearest() const {
    if (is_zero(found_.direction)) return true;
    const Dyadic height = dot(found_.direction, found_.corners[0].point);
    for (const Corner& corner : corners_) {
      if ((dot(found_.direction, corner.point) - height).sign() < 0) return false;
    }
    return true;
  }
};

Nearest nearest(const std::vector<Corner>& corners) {
  Candidate candidate(corners);
  const std::size_t n = corners.size();
  for (std::size_t a = 0; a < n; ++a) {
    if (candidate.try_point(a)) return candidate.found();
  }
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n; ++b) {
      if (candidate.try_segment(a, b)) return candidate.found();
    }
  }
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n; ++b) {
      for (std::size_t c = b + 1; c < n; ++c) {
        if (candidate.try_triangle(a, b, c)) return candidate.found();
      }
    }
  }
  candidate.take_tetrahedron();
  return candidate.found();
}

// The corner of conv(P) − conv(R) that is furthest against the direction.
Corner furthest_against(const PosedBody& guest, const PosedBody& host, const DyadicVec3& direction) {
  const Dyadic minus_one(-1.0);
  const DyadicVec3 in_guest = minus_one * rotate_back_exactly(guest.pose, direction);
  const DyadicVec3 in_host = rotate_back_exactly(host.pose, direction);
  Corner corner;
  corner.guest = extreme_exactly(guest.body->inner, in_guest);
  corner.host = extreme_exactly(host.body->inner, in_host);
  corner.point = apply_exactly(guest.pose, guest.body->inner.points[at(corner.guest)]) -
                 apply_exactly(host.pose, host.body->inner.points[at(corner.host)]);
  return corner;
}

}  // namespace

std::int32_t extreme_exactly(const Hierarchy& h, const DyadicVec3& u) {
  const ExactComparison comparison(u);
  std::int32_t v = h.top.front();
  for (const std::int32_t candidate : h.top) {
    if (comparison.sign(h.points[at(candidate)], h.points[at(v)]) > 0) v = candidate;
  }
  for (bool moved = true; moved;) {
    moved = false;
    const ChainRange chain = h.chains[at(v)];
    for (std::int32_t i = 0; i < chain.length && !moved; ++i) {
      const std::int32_t child = h.blocks[at(chain.first_block + i / kBlockLanes)].vertex[at(i % kBlockLanes)];
      if (comparison.sign(h.points[at(child)], h.points[at(v)]) > 0) {
        v = child;
        moved = true;
      }
    }
  }
  return v;
}

namespace {

// Whether the hulls come within the swell at the nearest point so far.
bool within(const Nearest& nearest, const Dyadic& square_of_swell) {
  if (is_zero(nearest.direction)) return true;
  if (square_of_swell.sign() == 0) return false;
  const Dyadic height = dot(nearest.direction, nearest.corners[0].point);
  return (height * height - square_of_swell * dot(nearest.direction, nearest.direction)).sign() <= 0;
}

// Whether all of the difference lies further along the direction than the swell, its least height being given.
bool beyond(const Dyadic& height, const DyadicVec3& direction, const Dyadic& square_of_swell) {
  if (height.sign() <= 0) return false;
  if (square_of_swell.sign() == 0) return true;
  return (height * height - square_of_swell * dot(direction, direction)).sign() > 0;
}

ExactAnswer shared_answer(const Nearest& nearest) {
  ExactAnswer answer;
  answer.shared = true;
  answer.count = static_cast<int>(nearest.corners.size());
  for (std::size_t i = 0; i < nearest.corners.size(); ++i) {
    answer.guest[i] = nearest.corners[i].guest;
    answer.host[i] = nearest.corners[i].host;
    answer.weight[i] = nearest.weights[i];
  }
  return answer;
}

}  // namespace

// Ends: unless it answers, a new corner is lower along the direction than the nearest point, which is therefore nearer
// the next time; and at the true nearest point one of the two tests answers.
ExactAnswer decide_exactly(const PosedBody& guest, const PosedBody& host, Vec3 hint, PairCounters&) {
  const Dyadic swell = Dyadic(guest.body->swell) + Dyadic(host.body->swell), square = swell * swell;
  DyadicVec3 direction(norm_1(hint) > 0 && std::isfinite(norm_1(hint)) ? hint : Vec3{1, 0, 0});
  std::vector<Corner> corners;
  for (;;) {
    Corner corner = furthest_against(guest, host, direction);
    if (beyond(dot(direction, corner.point), direction, square)) {
      ExactAnswer answer;
      answer.direction = direction;
      return answer;
    }
    corners.push_back(std::move(corner));
    Nearest next = nearest(corners);
    if (within(next, square)) return shared_answer(next);
    corners = std::move(next.corners);
    direction = std::move(next.direction);
  }
}

}  // namespace plannercheck
