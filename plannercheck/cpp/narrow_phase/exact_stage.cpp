#include "narrow_phase/exact_stage.hpp"

#include <vector>

#include "narrow_phase/simplex_projection.hpp"
#include "narrow_phase/support_exact_direction.hpp"

namespace plannercheck {
namespace {

struct Corner {
  std::int32_t body_a, body_b;
  DyadicVec3 point;  // A vertex − B vertex in the world
};

struct Nearest {
  std::vector<Corner> corners;  // the smallest set whose hull holds the nearest point in its interior
  std::array<Dyadic, 4> weights;
  DyadicVec3 direction;  // towards the nearest point; 0 if that is the origin
};

// Candidates for the nearest point of at most four corners' hull: the projection of the origin on the span of some of
// them. A candidate passes if it lies strictly between these corners and no other corner is nearer along it. Every
// candidate that passes is the nearest point, so the order of trying only matters for speed.
class Candidates {
 public:
  explicit Candidates(const std::vector<Corner>& corners) : corners_(corners) {}

  // Tries the sets (bits) that include `needed`, the larger first. One passes: a smallest set of corners that mixes the
  // nearest point is affinely independent, so its weights are positive and unique (Carathéodory).
  Nearest run(unsigned needed) {
    for (int size = static_cast<int>(corners_.size()); size > 0; --size) {
      for (unsigned set = 1; set < 1U << corners_.size(); ++set) {
        if ((set & needed) == needed && __builtin_popcount(set) == size && passes(set)) return found(set);
      }
    }
    return {};
  }

 private:
  const std::vector<Corner>& corners_;
  SimplexProjection<Dyadic, DyadicVec3> projection_;

  bool passes(unsigned set) {
    std::array<const DyadicVec3*, 4> p{};
    std::size_t n = 0;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if ((set >> i & 1U) != 0) p[n++] = &corners_[i].point;
    }
    if (!projection_.run(p, n)) return false;
    if (n == 4 || (n == 3 && projection_.height.sign() == 0)) projection_.towards = {};  // the origin is among them
    return none_nearer(set, *p[0]);
  }

  // Whether no corner outside the set is nearer along the direction (which is then that of the nearest point).
  bool none_nearer(unsigned set, const DyadicVec3& on_plane) const {
    if (is_zero(projection_.towards)) return true;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if ((set >> i & 1U) == 0 && dot(projection_.towards, corners_[i].point - on_plane).sign() < 0) return false;
    }
    return true;
  }

  Nearest found(unsigned set) {
    Nearest out;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if ((set >> i & 1U) != 0) out.corners.push_back(corners_[i]);
    }
    out.weights = std::move(projection_.weight);
    out.direction = std::move(projection_.towards);
    return out;
  }
};

Corner corner_at(const PosedPolytope& body_a, const PosedPolytope& body_b, std::int32_t p, std::int32_t r) {
  return {p, r,
          apply_exactly(body_a.pose, body_a.body->inner.points[at(p)]) -
              apply_exactly(body_b.pose, body_b.body->inner.points[at(r)])};
}

// The corner of conv(P) − conv(R) that is furthest against the direction.
Corner furthest_against(const PosedPolytope& body_a, const PosedPolytope& body_b, const DyadicVec3& direction) {
  const FineDirection in_a(-rotate_back_exactly(body_a.pose, direction));
  const FineDirection in_b(rotate_back_exactly(body_b.pose, direction));
  return corner_at(body_a, body_b, extreme(body_a.body->inner, in_a), extreme(body_b.body->inner, in_b));
}

// Whether a height along a direction exceeds the direction's length times the inflation radius.
bool exceeds(const Dyadic& height, const DyadicVec3& direction, const Dyadic& square_of_inflation_radius) {
  if (height.sign() <= 0) return false;
  if (square_of_inflation_radius.sign() == 0) return true;
  return (height * height - square_of_inflation_radius * dot(direction, direction)).sign() > 0;
}

// Whether the distance of the nearest point so far is at most the inflation radius.
bool within(const Nearest& nearest, const Dyadic& square_of_inflation_radius) {
  const Dyadic height = dot(nearest.direction, nearest.corners[0].point);
  return !exceeds(height, nearest.direction, square_of_inflation_radius);
}

ExactAnswer shared_answer(Nearest& nearest) {
  ExactAnswer answer;
  answer.shared = true;
  answer.count = static_cast<int>(nearest.corners.size());
  for (std::size_t i = 0; i < nearest.corners.size(); ++i) {
    answer.body_a[i] = nearest.corners[i].body_a;
    answer.body_b[i] = nearest.corners[i].body_b;
    answer.weight[i] = std::move(nearest.weights[i]);
  }
  return answer;
}

Nearest beginning(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start) {
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < static_cast<std::size_t>(start.count); ++i)
    corners.push_back(corner_at(body_a, body_b, start.body_a[i], start.body_b[i]));
  if (!corners.empty()) return Candidates(corners).run(0);
  const bool usable = norm_1(start.direction) > 0 && std::isfinite(norm_1(start.direction));
  Nearest nearest;
  nearest.direction = DyadicVec3(usable ? start.direction : Vec3{1, 0, 0});
  return nearest;
}

}  // namespace

// Termination: unless the loop answers, the new corner is lower along the direction than the nearest point. The next
// nearest point is mixed from it and others, and is nearer. At the true nearest point one of the two tests answers.
ExactAnswer decide_exactly(const PosedPolytope& body_a, const PosedPolytope& body_b, const Proximity& start) {
  const Dyadic inflation_radius = Dyadic(body_a.body->inflation_radius) + Dyadic(body_b.body->inflation_radius),
               square = inflation_radius * inflation_radius;
  Nearest nearest = beginning(body_a, body_b, start);
  for (;;) {
    if (!nearest.corners.empty() && within(nearest, square)) return shared_answer(nearest);
    Corner corner = furthest_against(body_a, body_b, nearest.direction);
    if (exceeds(dot(nearest.direction, corner.point), nearest.direction, square)) {
      ExactAnswer answer;
      answer.direction = std::move(nearest.direction);
      return answer;
    }
    nearest.corners.push_back(std::move(corner));
    nearest = Candidates(nearest.corners).run(1U << (nearest.corners.size() - 1));
  }
}

}  // namespace plannercheck
