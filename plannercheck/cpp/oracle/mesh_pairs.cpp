#include "oracle/mesh_pairs.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "oracle/triangles.hpp"
#include "oracle/winding.hpp"

namespace plannercheck::oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Box {
  std::array<double, 3> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  std::size_t triangle = 0;

  void add(const Box& other) {
    for (std::size_t k = 0; k < 3; ++k)
      low[k] = std::min(low[k], other.low[k]), high[k] = std::max(high[k], other.high[k]);
  }
  bool overlaps(const Box& other) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (low[k] > other.high[k] || other.low[k] > high[k]) return false;
    }
    return true;
  }
};

// Around the intervals of a triangle's corners, larger by `radius` on all sides, rounded outwards.
Box box_of(const PosedMesh& posed, std::size_t triangle, double radius) {
  Box out;
  out.triangle = triangle;
  for (const std::uint32_t vertex : posed.mesh().triangles[triangle]) {
    const IntervalVector& v = posed.about(vertex);
    const std::array<const Interval*, 3> of{&v.x, &v.y, &v.z};
    for (std::size_t k = 0; k < 3; ++k) {
      out.low[k] = std::min(out.low[k], -(of[k]->negated_low + radius));
      out.high[k] = std::max(out.high[k], of[k]->high + radius);
    }
  }
  return out;
}

std::vector<Box> boxes_of(const PosedMesh& posed, double radius) {
  std::vector<Box> out;
  for (std::size_t i = 0; i < posed.mesh().triangles.size(); ++i) out.push_back(box_of(posed, i, radius));
  return out;
}

Box around(const std::vector<Box>& boxes) {
  Box out;
  for (const Box& box : boxes) out.add(box);
  return out;
}

// Boxes that overlap another mesh's, in the order of their lower ends along an axis.
std::vector<Box> swept(std::vector<Box> boxes, const Box& others, std::size_t axis) {
  boxes.erase(std::remove_if(boxes.begin(), boxes.end(), [&](const Box& b) { return !b.overlaps(others); }),
              boxes.end());
  std::sort(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) { return a.low[axis] < b.low[axis]; });
  return boxes;
}

std::size_t longest_axis(const Box& a, const Box& b) {
  const auto shared = [&](std::size_t k) { return std::min(a.high[k], b.high[k]) - std::max(a.low[k], b.low[k]); };
  return shared(0) >= shared(1) && shared(0) >= shared(2) ? 0 : shared(1) >= shared(2) ? 1 : 2;
}

// Calls `test` with triangles of both whose boxes overlap, until it says true.
template <class Test>
bool any_overlapping(const std::vector<Box>& p, const std::vector<Box>& r, const Test& test) {
  const Box around_p = around(p), around_r = around(r);
  if (!around_p.overlaps(around_r)) return false;
  const std::size_t axis = longest_axis(around_p, around_r);
  const std::vector<Box> a = swept(p, around_r, axis), b = swept(r, around_p, axis);
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const bool is_first = a[i].low[axis] <= b[j].low[axis];
    const Box& box = is_first ? a[i++] : b[j++];
    const std::vector<Box>& others = is_first ? b : a;
    for (std::size_t k = is_first ? j : i; k < others.size() && others[k].low[axis] <= box.high[axis]; ++k) {
      if (!box.overlaps(others[k])) continue;
      const auto [first, second] =
          is_first ? std::pair(box.triangle, others[k].triangle) : std::pair(others[k].triangle, box.triangle);
      if (test(first, second)) return true;
    }
  }
  return false;
}

template <class Test>
bool any_at_all(const MeshPair& pair, const Test& test) {
  for (std::size_t i = 0; i < pair.p.mesh().triangles.size(); ++i) {
    for (std::size_t j = 0; j < pair.r.mesh().triangles.size(); ++j) {
      if (test(i, j)) return true;
    }
  }
  return false;
}

Meeting meeting_of_triangles(const MeshPair& pair, bool every) {
  Meeting found = Meeting::kNone;
  const bool is_inflated = pair.radius_exactly().sign() > 0;
  const auto test = [&](std::size_t i, std::size_t j) {
    const Triangle s = triangle_of(pair.p, i), t = triangle_of(pair.r, j);
    if (triangles_meet(pair, s, t)) {
      found = Meeting::kTriangles;
    } else if (is_inflated && triangles_within_radii(pair, s, t)) {
      found = Meeting::kWithinRadii;
    }
    return found != Meeting::kNone;
  };
  if (every || !pair.uses_intervals()) {
    any_at_all(pair, test);
  } else {
    any_overlapping(boxes_of(pair.p, pair.radius_about().high), boxes_of(pair.r, 0), test);
  }
  return found;
}

bool is_inside(const MeshPair& pair, const PosedMesh& part, const PosedMesh& whole, bool every) {
  if (!whole.mesh().is_closed) return false;
  const auto winds = [&](std::uint32_t vertex) {
    return winding_number(pair, {&part, vertex}, whole).value_or(1) != 0;
  };
  const auto& ones = part.mesh().component_vertices;
  const auto& triangles = part.mesh().triangles;
  return every ? std::any_of(triangles.begin(), triangles.end(),
                             [&](const auto& t) { return std::any_of(t.begin(), t.end(), winds); })
               : std::any_of(ones.begin(), ones.end(), winds);
}

}  // namespace

Meeting meeting(const MeshPair& pair, bool every) {
  const Meeting found = meeting_of_triangles(pair, every);
  if (found != Meeting::kNone) return found;
  if (is_inside(pair, pair.p, pair.r, every)) return Meeting::kFirstInside;
  if (is_inside(pair, pair.r, pair.p, every)) return Meeting::kSecondInside;
  return Meeting::kNone;
}

}  // namespace plannercheck::oracle
