// Where the walk in the plane starts: at the places where two polygons face each other, judged by a few vertices.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "math/shuffle.hpp"
#include "planar/polygon_signs.hpp"

namespace plannercheck {

// How many vertices of a polygon are probed, evenly spread; a power of two. Polygons with fewer repeat some.
inline constexpr std::size_t kPlanarProbes = 16;
// Polygons with fewer vertices start at thirds: they take a round or two from anywhere.
inline constexpr std::size_t kFewestProbed = 6;

namespace planar_detail {

typedef double Pair __attribute__((vector_size(16)));
typedef long long PairBits __attribute__((vector_size(16)));

inline std::size_t probe(const PlanarPolygon& polygon, std::size_t k) { return k * polygon.count / kPlanarProbes; }

inline Pair load_vertex(const PlanarPolygon& polygon, std::size_t k) {
  Pair vertex;
  std::memcpy(&vertex, polygon.vertices + 2 * k, sizeof vertex);
  return vertex;
}

// The mean of four vertices, in the world.
inline std::array<double, 2> middle(const PosedPolygon& body) {
  constexpr std::size_t step = kPlanarProbes / 4;
  Pair sum{};
  for (std::size_t k = 0; k < kPlanarProbes; k += step) sum += load_vertex(body.shape, probe(body.shape, k));
  const auto& m = body.pose.m;
  const double x = sum[0] / 4, y = sum[1] / 4;
  return {m[0] * x + m[1] * y + m[2], m[3] * x + m[4] * y + m[5]};
}

// The probe furthest along a direction of the world. Each product carries its probe's number in its last bits, so that
// one maximum gives both; if products are not finite, the result is some probe.
inline std::size_t furthest_probe(const PosedPolygon& body, double x, double y) {
  const auto& m = body.pose.m;
  const Pair along{m[0] * x + m[3] * y, m[1] * x + m[4] * y};
  std::array<Pair, kPlanarProbes / 2> most;
  for (std::size_t k = 0; k < kPlanarProbes; k += 2) {
    const Pair a = along * load_vertex(body.shape, probe(body.shape, k));
    const Pair b = along * load_vertex(body.shape, probe(body.shape, k + 1));
    const Pair products = shuffled<0, 2>(a, b) + shuffled<1, 3>(a, b);
    const auto tag = static_cast<long long>(k);
    const PairBits tagged =
        (reinterpret_cast<PairBits>(products) & ~static_cast<long long>(kPlanarProbes - 1)) | PairBits{tag, tag + 1};
    most[k / 2] = reinterpret_cast<Pair>(tagged);
  }
  for (std::size_t half = kPlanarProbes / 4; half >= 1; half /= 2) {
    for (std::size_t k = 0; k < half; ++k) most[k] = most[k] > most[k + half] ? most[k] : most[k + half];
  }
  const double best = most[0][0] > most[0][1] ? most[0][0] : most[0][1];
  return std::bit_cast<std::uint64_t>(best) & (kPlanarProbes - 1);
}

// The probe and its neighbours; if all vertices are probes, the vertices on either side.
inline std::array<std::size_t, 3> probes_around(const PlanarPolygon& polygon, std::size_t k) {
  const std::size_t n = polygon.count, here = probe(polygon, k);
  if (n < kPlanarProbes) return {(here == 0 ? n : here) - 1, here, here + 1 == n ? 0 : here + 1};
  return {probe(polygon, (k + kPlanarProbes - 1) % kPlanarProbes), here, probe(polygon, (k + 1) % kPlanarProbes)};
}

}  // namespace planar_detail

// Three places of a polygon, in order, from which the walk starts. Any three are right; those around the probe furthest
// towards the other polygon end it soonest.
struct PlanarStart {
  std::array<std::size_t, 3> body_a, body_b;

  // Takes thirds if `first` rules out doubles.
  PlanarStart(const PosedPolygon& a, const PosedPolygon& b, Precision first, PlanarCounters& counters)
      : body_a(thirds(a.shape.count)), body_b(thirds(b.shape.count)) {
    const bool has_a = a.shape.count >= kFewestProbed, has_b = b.shape.count >= kFewestProbed;
    if (first != Precision::kDoubles || !(has_a || has_b)) return;
    const auto from = planar_detail::middle(a), to = planar_detail::middle(b);
    const double x = to[0] - from[0], y = to[1] - from[1];
    if (has_a) body_a = facing(a, x, y, counters);
    if (has_b) body_b = facing(b, -x, -y, counters);
  }

 private:
  static std::array<std::size_t, 3> thirds(std::size_t n) { return {0, n / 3, 2 * n / 3}; }
  static std::array<std::size_t, 3> facing(const PosedPolygon& body, double x, double y, PlanarCounters& counters) {
    counters.vertices += kPlanarProbes;
    return planar_detail::probes_around(body.shape, planar_detail::furthest_probe(body, x, y));
  }
};

}  // namespace plannercheck
