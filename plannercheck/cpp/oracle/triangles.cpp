#include "oracle/triangles.hpp"

#include <algorithm>
#include <array>

namespace plannercheck::oracle {
namespace {

constexpr int kAxes = 3;

template <class Vector>
const auto& coordinate(const Vector& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

bool are_opposite(int a, int b) { return a * b < 0; }
bool are_alike(int a, int b) { return a * b > 0; }

// Segments pq and ab, projected along an axis.
bool projected_segments_meet(const MeshPair& pair, const Corner& p, const Corner& q, const Corner& a, const Corner& b,
                             int drop) {
  const int a_side = orientation_in_plane(pair, p, q, a, drop), b_side = orientation_in_plane(pair, p, q, b, drop);
  if (are_alike(a_side, b_side)) return false;
  const int p_side = orientation_in_plane(pair, a, b, p, drop), q_side = orientation_in_plane(pair, a, b, q, drop);
  if (are_alike(p_side, q_side)) return false;
  if (a_side != 0 || b_side != 0 || p_side != 0 || q_side != 0) return true;
  // All on one line, or both segments are points: they meet if they overlap in both coordinates.
  for (int axis = 0; axis < kAxes; ++axis) {
    if (axis == drop) continue;
    const bool is_below = compare(pair, p, a, axis) < 0 && compare(pair, p, b, axis) < 0 &&
                          compare(pair, q, a, axis) < 0 && compare(pair, q, b, axis) < 0;
    const bool is_above = compare(pair, p, a, axis) > 0 && compare(pair, p, b, axis) > 0 &&
                          compare(pair, q, a, axis) > 0 && compare(pair, q, b, axis) > 0;
    if (is_below || is_above) return false;
  }
  return true;
}

bool projected_segment_meets(const MeshPair& pair, const Corner& p, const Corner& q, const Triangle& t, int drop) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (projected_segments_meet(pair, p, q, t[k], t[(k + 1) % 3], drop)) return true;
  }
  const int first = orientation_in_plane(pair, t[0], t[1], p, drop);
  return first != 0 && first == orientation_in_plane(pair, t[1], t[2], p, drop) &&
         first == orientation_in_plane(pair, t[2], t[0], p, drop);
}

// `p_side`, `q_side`: on which side of the triangle's plane the ends of segment pq are; 0 if it is a segment or point.
bool segment_meets(const MeshPair& pair, const Corner& p, const Corner& q, int p_side, int q_side, const Triangle& t) {
  if (are_alike(p_side, q_side)) return false;
  std::array<int, 3> turns{};
  for (std::size_t k = 0; k < 3; ++k) turns[k] = orientation(pair, p, q, t[k], t[(k + 1) % 3]);
  const bool is_aside =
      are_opposite(turns[0], turns[1]) || are_opposite(turns[1], turns[2]) || are_opposite(turns[2], turns[0]);
  if (p_side != 0 || q_side != 0) return !is_aside;
  if (turns != std::array<int, 3>{}) return false;  // The triangle is a segment, askew to pq.
  // Five points in one plane: one of the projections is one to one on it, and all others follow it.
  for (int drop = 0; drop < kAxes; ++drop) {
    if (!projected_segment_meets(pair, p, q, t, drop)) return false;
  }
  return true;
}

using Sides = std::array<int, 3>;

Sides sides_of(const MeshPair& pair, const Triangle& s, const Triangle& plane) {
  Sides out{};
  for (std::size_t k = 0; k < 3; ++k) out[k] = orientation(pair, plane[0], plane[1], plane[2], s[k]);
  return out;
}

bool is_on_one_side(const Sides& sides) { return are_alike(sides[0], sides[1]) && are_alike(sides[1], sides[2]); }

bool an_edge_meets(const MeshPair& pair, const Triangle& s, const Sides& sides, const Triangle& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (segment_meets(pair, s[k], s[next], sides[k], sides[next], t)) return true;
  }
  return false;
}

bool points_within(const MeshPair& pair, const Corner& p, const Corner& q) {
  return pair.sign([&](const auto& at) {
    const auto d = at(p) - at(q);
    return dot(d, d) - at.radius() * at.radius();
  }) <= 0;
}

// Where p is nearest to an inner point of segment ab: whether it is within the radii of it.
bool point_and_segment_within(const MeshPair& pair, const Corner& p, const Corner& a, const Corner& b) {
  const auto is_past = [&](const Corner& from, const Corner& to) {
    return pair.sign([&](const auto& at) { return dot(at(p) - at(from), at(to) - at(from)); }) > 0;
  };
  return is_past(a, b) && is_past(b, a) && pair.sign([&](const auto& at) {
    const auto along = at(b) - at(a), moment = cross(along, at(p) - at(a));
    return dot(moment, moment) - at.radius() * at.radius() * dot(along, along);
  }) <= 0;
}

// Where the common perpendicular of two segments ends on both: whether it is within the radii.
bool segments_within(const MeshPair& pair, const Corner& p, const Corner& q, const Corner& a, const Corner& b) {
  // Ends of one segment seen along the perpendicular from the other, on two sides or on the line.
  const auto crosses = [&](const Corner& from, const Corner& to, const Corner& c, const Corner& d) {
    const auto side = [&](const Corner& end) {
      return pair.sign([&](const auto& at) {
        const auto along = at(to) - at(from);
        return dot(cross(cross(along, at(d) - at(c)), along), at(end) - at(from));
      });
    };
    return !are_alike(side(c), side(d));
  };
  const auto normal_is_zero = [&] {
    return pair.sign([&](const auto& at) {
      const auto normal = cross(at(q) - at(p), at(b) - at(a));
      return dot(normal, normal);
    }) == 0;
  };
  return crosses(p, q, a, b) && crosses(a, b, p, q) && !normal_is_zero() && pair.sign([&](const auto& at) {
    const auto normal = cross(at(q) - at(p), at(b) - at(a));
    const auto height = dot(normal, at(a) - at(p));
    return height * height - at.radius() * at.radius() * dot(normal, normal);
  }) <= 0;
}

// Where p lies over an inner point of a triangle: whether it is within the radii of it.
bool point_and_face_within(const MeshPair& pair, const Corner& p, const Triangle& t) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Corner &a = t[k], &b = t[(k + 1) % 3];
    const bool is_within = pair.sign([&](const auto& at) {
      const auto normal = cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
      return dot(cross(normal, at(b) - at(a)), at(p) - at(a));
    }) > 0;
    if (!is_within) return false;
  }
  return pair.sign([&](const auto& at) {
    const auto normal = cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
    const auto height = dot(normal, at(p) - at(t[0]));
    return height * height - at.radius() * at.radius() * dot(normal, normal);
  }) <= 0;
}

}  // namespace

int orientation(const MeshPair& pair, const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
  return pair.sign([&](const auto& at) { return dot(cross(at(b) - at(a), at(c) - at(a)), at(d) - at(a)); });
}

int orientation_in_plane(const MeshPair& pair, const Corner& a, const Corner& b, const Corner& c, int drop) {
  return pair.sign([&](const auto& at) {
    const auto ab = at(b) - at(a), ac = at(c) - at(a);
    const int u = (drop + 1) % kAxes, v = (drop + 2) % kAxes;
    return coordinate(ab, u) * coordinate(ac, v) - coordinate(ab, v) * coordinate(ac, u);
  });
}

int compare(const MeshPair& pair, const Corner& a, const Corner& b, int axis) {
  return pair.sign([&](const auto& at) { return coordinate(at(a), axis) - coordinate(at(b), axis); });
}

bool triangles_meet(const MeshPair& pair, const Triangle& s, const Triangle& t) {
  const Sides s_sides = sides_of(pair, s, t);
  if (is_on_one_side(s_sides)) return false;
  const Sides t_sides = sides_of(pair, t, s);
  if (is_on_one_side(t_sides)) return false;
  return an_edge_meets(pair, s, s_sides, t) || an_edge_meets(pair, t, t_sides, s);
}

bool triangles_within_radii(const MeshPair& pair, const Triangle& s, const Triangle& t) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next_i = (i + 1) % 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t next_j = (j + 1) % 3;
      if (points_within(pair, s[i], t[j]) || point_and_segment_within(pair, s[i], t[j], t[next_j]) ||
          point_and_segment_within(pair, t[j], s[i], s[next_i]) ||
          segments_within(pair, s[i], s[next_i], t[j], t[next_j]))
        return true;
    }
    if (point_and_face_within(pair, s[i], t) || point_and_face_within(pair, t[i], s)) return true;
  }
  return false;
}

}  // namespace plannercheck::oracle
