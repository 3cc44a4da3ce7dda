#include "narrow_phase/facet_planes.hpp"

#include <algorithm>
#include <array>

#include "math/double4.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kCornerQuads = kFewCorners / kQuad;

// Lanes beyond the last corner repeat it.
struct Corners {
  std::array<double, kFewCorners> x, y, z;

  void put(std::size_t quad, Quad px, Quad py, Quad pz) {
    store_quad(&x[quad * kQuad], px), store_quad(&y[quad * kQuad], py), store_quad(&z[quad * kQuad], pz);
  }
};

// The guest's corners in the host's frame; rounded as PairFrame::guest_vertex.
Corners guest_corners(const PairFrame& frame) {
  const std::array<double, 9>& m = frame.rotation();
  const Vec3 shift = frame.shift();
  Corners out;
  for (std::size_t i = 0; i < kCornerQuads; ++i) {
    const Block& p = frame.guest().inner.top_stands[i];
    const Quad x = load_quad(p.x.data()), y = load_quad(p.y.data()), z = load_quad(p.z.data());
    out.put(i, (m[0] * x + m[1] * y) + (m[2] * z + shift.x), (m[3] * x + m[4] * y) + (m[5] * z + shift.y),
            (m[6] * x + m[7] * y) + (m[8] * z + shift.z));
  }
  return out;
}

// Approximately the host's corners in the guest's frame, relative to the guest's centre.
Corners host_corners(const PairFrame& frame) {
  const std::array<double, 9>& m = frame.rotation();
  const Vec3 origin = frame.host().centre + frame.guest_centre();
  Corners out;
  for (std::size_t i = 0; i < kCornerQuads; ++i) {
    const Block& p = frame.host().inner.top_stands[i];
    const Quad x = load_quad(p.x.data()) - origin.x, y = load_quad(p.y.data()) - origin.y;
    const Quad z = load_quad(p.z.data()) - origin.z;
    out.put(i, (m[0] * x + m[3] * y) + m[6] * z, (m[1] * x + m[4] * y) + m[7] * z, (m[2] * x + m[5] * y) + m[8] * z);
  }
  return out;
}

// A facet, as a point q of the polar, and the least q·x over the other body's corners; above 1, they are all beyond it.
struct Facet {
  Vec3 q;
  double least;
};

// The facet beyond which the corners lie furthest.
Facet furthest_facet(const Levels& polar, const Corners& corners) {
  Quad best = Quad{} - __builtin_inf();
  QuadMask block = {};
  const std::size_t blocks = std::min((polar.points.size() + kQuad - 1) / kQuad, polar.top_stands.size());
  for (std::size_t f = 0; f < blocks; ++f) {
    const Block& facets = polar.top_stands[f];
    const Quad qx = load_quad(facets.x.data()), qy = load_quad(facets.y.data()), qz = load_quad(facets.z.data());
    Quad least = Quad{} + __builtin_inf();
#pragma GCC unroll 8
    for (std::size_t i = 0; i < kFewCorners; ++i) {
      const Quad value = (qx * corners.x[i] + qy * corners.y[i]) + qz * corners.z[i];
      least = value < least ? value : least;
    }
    const QuadMask better = least > best;
    best = better ? least : best;
    block = better ? QuadMask{} + static_cast<long long>(f) : block;
  }
  std::size_t lane = 0;
  for (std::size_t k = 1; k < kQuad; ++k) lane = best[k] > best[lane] ? k : lane;
  return {polar.top_stands[static_cast<std::size_t>(block[lane])].point(lane), best[lane]};
}

Certificate separated_by(Vec3 q) {
  Certificate out;
  out.answer = Answer::kSeparated;
  out.stage = Stage::kFacetPlane;
  out.q = q;
  return out;
}

}  // namespace

Certificate facet_plane(const PairFrame& frame, const CentreAxis& axis, PairCounters& counters) {
  const Facet of_host = furthest_facet(frame.host().polar, guest_corners(frame));
  counters.queries.blocks += static_cast<long>(kFewCorners * frame.host().polar.top_stands.size());
  if (frame.separates(of_host.q, of_host.least)) return separated_by(of_host.q);
  const Facet of_guest = furthest_facet(frame.guest().polar, host_corners(frame));
  counters.queries.blocks += static_cast<long>(kFewCorners * frame.guest().polar.top_stands.size());
  if (!(of_guest.least > 1)) return {};
  const Vec3 towards_guest = -frame.posed_guest().pose.rotate(of_guest.q);
  return axis.separates(towards_guest, frame.defect(), counters) ? separated_by(axis.touching_ball(towards_guest))
                                                                 : Certificate{};
}

}  // namespace plannercheck
