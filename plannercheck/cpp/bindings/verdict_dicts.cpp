#include "bindings/verdict_dicts.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <array>

#include "bindings/array_types.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

nb::tuple exact_number(const Dyadic& number) { return nb::make_tuple(number.hexadecimal(), number.exponent()); }

nb::tuple exact_vector(const DyadicVec3& v) {
  return nb::make_tuple(exact_number(v.x), exact_number(v.y), exact_number(v.z));
}

// Weights as doubles with sum 1. Their powers of two may be too large for doubles, so they are scaled together.
std::vector<double> weights_of(const ExactAnswer& answer) {
  const auto count = static_cast<std::size_t>(answer.count);
  std::int64_t top = INT64_MIN;
  for (std::size_t i = 0; i < count; ++i) top = std::max(top, answer.weight[i].log2());
  std::vector<double> weights;
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    weights.push_back(answer.weight[i].to_double(-top));
    sum += weights.back();
  }
  for (double& w : weights) w /= sum;
  return weights;
}

Vec3 vertex_in_world(const PosedPolytope& posed, std::int32_t v) {
  return posed.pose.apply(posed.body->inner.points[static_cast<std::size_t>(v)]);
}

void put_shared(nb::dict& out, const ExactAnswer& answer, const PosedPolytope& body_a, const PosedPolytope& body_b,
                bool first_is_a) {
  const std::vector<double> weights = weights_of(answer);
  std::vector<std::int32_t> indices_a, indices_b;
  nb::list exact_weights;
  Vec3 on_body_a, on_body_b;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    indices_a.push_back(answer.body_a[i]);
    indices_b.push_back(answer.body_b[i]);
    exact_weights.append(exact_number(answer.weight[i]));
    on_body_a = on_body_a + weights[i] * vertex_in_world(body_a, answer.body_a[i]);
    on_body_b = on_body_b + weights[i] * vertex_in_world(body_b, answer.body_b[i]);
  }
  const double inflation_radius = body_a.body->inflation_radius + body_b.body->inflation_radius;
  out["point"] = point_array(on_body_a + (inflation_radius > 0 ? body_a.body->inflation_radius / inflation_radius : 0) *
                                             (on_body_b - on_body_a));
  out["exact_weights"] = exact_weights;
  out["vertices_a"] = output_array(first_is_a ? indices_a : indices_b, {weights.size()});
  out["vertices_b"] = output_array(first_is_a ? indices_b : indices_a, {weights.size()});
}

constexpr std::array<const char*, kStages> kStageNames{"cached plane",   "box face",      "centre axis", "solver",
                                                       "nearest points", "double-double", "exact"};

}  // namespace

nb::dict counters_dict(const PairCounters& c) {
  using C = PairCounters;
  nb::dict out =
      named_counters(c.queries, {{"blocks", &QueryCounters::blocks}, {"exact_comparisons", &QueryCounters::exact}});
  out.update(named_counters(
      c, {{"queries_a", &C::queries_a}, {"queries_b", &C::queries_b}, {"games", &C::games}, {"rounds", &C::rounds}}));
  return out;
}

nb::dict verdict_dict(const PairVerdict& verdict, const PosedPolytope& body_a, const PosedPolytope& body_b,
                      bool first_is_a) {
  nb::dict out;
  out["shared"] = verdict.shared;
  out["stage"] = kStageNames[static_cast<std::size_t>(verdict.stage)];
  if (!verdict.shared) {
    const auto [rounded, exact] = direction_found(verdict, body_b);
    out["normal"] = point_array(first_is_a ? rounded : -rounded);
    if (exact) out["exact_normal"] = exact_vector(first_is_a ? *exact : -*exact);
  } else if (verdict.exact) {
    put_shared(out, *verdict.exact, body_a, body_b, first_is_a);
  } else {
    const bool near = verdict.stage == Stage::kNearest || verdict.stage == Stage::kDoubleDouble;
    out["point"] =
        point_array(near ? verdict.proximity.point : body_b.pose.apply(body_b.body->centre + verdict.certificate.x));
  }
  return out;
}

}  // namespace plannercheck
