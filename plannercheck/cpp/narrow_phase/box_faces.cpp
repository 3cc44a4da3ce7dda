#include "narrow_phase/box_faces.hpp"

namespace plannercheck {
namespace {

struct Face {
  double gap = -__builtin_inf();  // between both boxes
  int axis = -1;
  double side = 0;  // 1 or -1: on which A lies
  bool of_b = false;
};

Vec3 column(const PairFrame& frame, int j) {
  const std::array<double, 9>& m = frame.rotation();
  return {m[at(j)], m[at(j + 3)], m[at(j + 6)]};
}

Face best_face(const PairFrame& frame, Vec3 centre_a) {
  const Polytope &g = frame.body_a(), &h = frame.body_b();
  const Vec3 half_a = 0.5 * (g.high - g.low), half_b = 0.5 * (h.high - h.low);
  const Vec3 d = centre_a - (0.5 * (h.low + h.high) - h.centre);
  const std::array<double, 9>& m = frame.rotation();
  Face best;
  const auto take = [&](double along, double halves, int axis, bool of_b) {
    const double gap = std::fabs(along) - halves;
    if (gap > best.gap) best = {gap, axis, along < 0 ? -1.0 : 1.0, of_b};
  };
  for (int i = 0; i < 3 && g.is_box == 0; ++i) {
    const double* const row = m.data() + 3 * i;
    const double half = std::fabs(row[0]) * half_a.x + std::fabs(row[1]) * half_a.y + std::fabs(row[2]) * half_a.z;
    take(d[i], half + half_b[i], i, true);
  }
  for (int j = 0; j < 3 && h.is_box == 0; ++j) {
    const Vec3 u = column(frame, j);
    const double half = std::fabs(u.x) * half_b.x + std::fabs(u.y) * half_b.y + std::fabs(u.z) * half_b.z;
    take(dot(u, d), half + half_a[j], j, false);
  }
  return best;
}

// The plane of a face of B's box, against A's vertices.
Certificate by_face_of_b(const PairFrame& frame, const Face& face, PairCounters& counters) {
  const Polytope& h = frame.body_b();
  const double height =
      face.side > 0 ? h.high[face.axis] - h.centre[face.axis] : h.centre[face.axis] - h.low[face.axis];
  const double entry = face.side / height;
  const Vec3 q{face.axis == 0 ? entry : 0, face.axis == 1 ? entry : 0, face.axis == 2 ? entry : 0};
  ++counters.queries_a;
  const std::int32_t lowest = extreme(frame.body_a().inner, frame.direction_a(q), counters.queries);
  return frame.separates(q, dot(q, frame.vertex_a(lowest))) ? separated_by(q, Stage::kBoxFace) : Certificate{};
}

// A plane parallel to a face of A's box that touches B, against that box: along the face's normal, a
// column of M_Rᵀ M_P, the box' half edges reach as far as they are long but for kAxisDefect of them.
Certificate by_face_of_a(const PairFrame& frame, const Face& face, Vec3 centre_a, PairCounters& counters) {
  const Polytope &g = frame.body_a(), &h = frame.body_b();
  const Vec3 u = face.side * column(frame, face.axis), half = 0.5 * (g.high - g.low);
  ++counters.queries_b;
  const std::int32_t highest = extreme(h.inner, u, counters.queries);
  const double height = dot(u, h.inner.points[at(highest)] - h.centre);
  if (!(height > 0)) return {};
  const Vec3 q = (1 / height) * u;
  const double lowest = dot(u, centre_a) - (half[face.axis] + kAxisDefect * (half.x + half.y + half.z));
  return frame.separates(q, lowest / height) ? separated_by(q, Stage::kBoxFace) : Certificate{};
}

}  // namespace

Certificate box_face(const PairFrame& frame, PairCounters& counters) {
  const Polytope& g = frame.body_a();
  const Vec3 centre_a = frame.point_a(0.5 * (g.low + g.high));
  const Face best = best_face(frame, centre_a);
  if (best.axis < 0) return {};
  return best.of_b ? by_face_of_b(frame, best, counters) : by_face_of_a(frame, best, centre_a, counters);
}

}  // namespace plannercheck
