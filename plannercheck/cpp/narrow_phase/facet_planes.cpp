#include "narrow_phase/facet_planes.hpp"

#include <algorithm>
#include <array>

#include "math/double4.hpp"

namespace plannercheck {
namespace {

constexpr std::size_t kCornerVectors = kFewCorners / kDouble4Lanes;

// Lanes beyond the last corner repeat it.
struct Corners {
  std::array<double, kFewCorners> x, y, z;

  void put(std::size_t index, Double4 px, Double4 py, Double4 pz) {
    store_double4(&x[index * kDouble4Lanes], px), store_double4(&y[index * kDouble4Lanes], py),
        store_double4(&z[index * kDouble4Lanes], pz);
  }
};

// The guest's corners in the host's frame; rounded as PairFrame::guest_vertex.
Corners guest_corners(const PairFrame& frame) {
  const std::array<double, 9>& m = frame.rotation();
  const Vec3 shift = frame.shift();
  Corners out;
  for (std::size_t i = 0; i < kCornerVectors; ++i) {
    const VertexBlock& p = frame.guest().inner.top_cursors[i];
    const Double4 x = load_double4(p.x.data()), y = load_double4(p.y.data()), z = load_double4(p.z.data());
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
  for (std::size_t i = 0; i < kCornerVectors; ++i) {
    const VertexBlock& p = frame.host().inner.top_cursors[i];
    const Double4 x = load_double4(p.x.data()) - origin.x, y = load_double4(p.y.data()) - origin.y;
    const Double4 z = load_double4(p.z.data()) - origin.z;
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
  Double4 best = Double4{} - __builtin_inf();
  Double4Mask block = {};
  const std::size_t blocks =
      std::min((polar.points.size() + kDouble4Lanes - 1) / kDouble4Lanes, polar.top_cursors.size());
  for (std::size_t f = 0; f < blocks; ++f) {
    const VertexBlock& facets = polar.top_cursors[f];
    const Double4 qx = load_double4(facets.x.data()), qy = load_double4(facets.y.data()),
                  qz = load_double4(facets.z.data());
    Double4 least = Double4{} + __builtin_inf();
#pragma GCC unroll 8
    for (std::size_t i = 0; i < kFewCorners; ++i) {
      const Double4 value = (qx * corners.x[i] + qy * corners.y[i]) + qz * corners.z[i];
      least = value < least ? value : least;
    }
    const Double4Mask better = least > best;
    best = better ? least : best;
    block = better ? Double4Mask{} + static_cast<long long>(f) : block;
  }
  std::size_t lane = 0;
  for (std::size_t k = 1; k < kDouble4Lanes; ++k) lane = best[k] > best[lane] ? k : lane;
  return {polar.top_cursors[static_cast<std::size_t>(block[lane])].point(lane), best[lane]};
}

}  // namespace

Certificate facet_plane(const PairFrame& frame, const Pose& guest, const CentreAxis& axis, PairCounters& counters) {
  const Facet of_host = furthest_facet(frame.host().polar, guest_corners(frame));
  counters.queries.blocks += static_cast<long>(kFewCorners * frame.host().polar.top_cursors.size());
  if (frame.separates(of_host.q, of_host.least)) return separated_by(of_host.q, Stage::kFacetPlane);
  const Facet of_guest = furthest_facet(frame.guest().polar, host_corners(frame));
  counters.queries.blocks += static_cast<long>(kFewCorners * frame.guest().polar.top_cursors.size());
  if (!(of_guest.least > 1)) return {};
  const Vec3 towards_guest = -guest.rotate(of_guest.q);
  return axis.separates(towards_guest, frame.defect(), counters)
             ? separated_by(axis.touching_ball(towards_guest), Stage::kFacetPlane)
             : Certificate{};
}

}  // namespace plannercheck
