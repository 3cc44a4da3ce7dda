#include "narrow_phase/box_faces.hpp"

namespace plannercheck {
namespace {

struct Face {
  double gap = -__builtin_inf();  // between both boxes
  int axis = -1;
  double side = 0;  // 1 or -1: on which the guest lies
  bool of_host = false;
};

Vec3 column(const PairFrame& frame, int j) {
  const std::array<double, 9>& m = frame.rotation();
  return {m[at(j)], m[at(j + 3)], m[at(j + 6)]};
}

Face best_face(const PairFrame& frame, Vec3 guest_centre) {
  const Polytope &g = frame.guest(), &h = frame.host();
  const Vec3 guest_half = 0.5 * (g.high - g.low), host_half = 0.5 * (h.high - h.low);
  const Vec3 d = guest_centre - (0.5 * (h.low + h.high) - h.centre);
  const std::array<double, 9>& m = frame.rotation();
  Face best;
  const auto take = [&](double along, double halves, int axis, bool of_host) {
    const double gap = std::fabs(along) - halves;
    if (gap > best.gap) best = {gap, axis, along < 0 ? -1.0 : 1.0, of_host};
  };
  for (int i = 0; i < 3 && g.is_box == 0; ++i) {
    const double* const row = m.data() + 3 * i;
    const double half =
        std::fabs(row[0]) * guest_half.x + std::fabs(row[1]) * guest_half.y + std::fabs(row[2]) * guest_half.z;
    take(d[i], half + host_half[i], i, true);
  }
  for (int j = 0; j < 3 && h.is_box == 0; ++j) {
    const Vec3 u = column(frame, j);
    const double half = std::fabs(u.x) * host_half.x + std::fabs(u.y) * host_half.y + std::fabs(u.z) * host_half.z;
    take(dot(u, d), half + guest_half[j], j, false);
  }
  return best;
}

// The plane of a face of the host's box, against the guest's vertices.
Certificate by_host_face(const PairFrame& frame, const Face& face, PairCounters& counters) {
  const Polytope& h = frame.host();
  const double height =
      face.side > 0 ? h.high[face.axis] - h.centre[face.axis] : h.centre[face.axis] - h.low[face.axis];
  const double entry = face.side / height;
  const Vec3 q{face.axis == 0 ? entry : 0, face.axis == 1 ? entry : 0, face.axis == 2 ? entry : 0};
  ++counters.guest_queries;
  const std::int32_t lowest = extreme(frame.guest().inner, frame.guest_direction(q), counters.queries);
  return frame.separates(q, dot(q, frame.guest_vertex(lowest))) ? separated_by(q, Stage::kBoxFace) : Certificate{};
}

// A plane parallel to a face of the guest's box that touches the host, against that box: along the face's normal, a
// column of M_Rᵀ M_P, the box' half edges reach as far as they are long but for kAxisDefect of them.
Certificate by_guest_face(const PairFrame& frame, const Face& face, Vec3 guest_centre, PairCounters& counters) {
  const Polytope &g = frame.guest(), &h = frame.host();
  const Vec3 u = face.side * column(frame, face.axis), half = 0.5 * (g.high - g.low);
  ++counters.host_queries;
  const std::int32_t highest = extreme(h.inner, u, counters.queries);
  const double height = dot(u, h.inner.points[at(highest)] - h.centre);
  if (!(height > 0)) return {};
  const Vec3 q = (1 / height) * u;
  const double lowest = dot(u, guest_centre) - (half[face.axis] + kAxisDefect * (half.x + half.y + half.z));
  return frame.separates(q, lowest / height) ? separated_by(q, Stage::kBoxFace) : Certificate{};
}

}  // namespace

Certificate box_face(const PairFrame& frame, PairCounters& counters) {
  const Polytope& g = frame.guest();
  const Vec3 guest_centre = frame.guest_point(0.5 * (g.low + g.high));
  const Face best = best_face(frame, guest_centre);
  if (best.axis < 0) return {};
  return best.of_host ? by_host_face(frame, best, counters) : by_guest_face(frame, best, guest_centre, counters);
}

}  // namespace plannercheck
