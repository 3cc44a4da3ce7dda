#include "verdicts.hpp"

#include <nanobind/ndarray.h>

#include "array_types.hpp"

namespace nb = nanobind;

namespace plannercheck {
namespace {

auto row_of(Vec3 v) { return output_array(std::vector<double>{v.x, v.y, v.z}, {std::size_t{3}}); }

// Weights as doubles with sum 1; they differ by powers of two too large for doubles, so they are scaled together.
std::vector<double> weights_of(const ExactAnswer& answer) {
  std::int64_t top = INT64_MIN;
  for (std::size_t i = 0; i < static_cast<std::size_t>(answer.count); ++i) top = std::max(top, answer.weight[i].log2());
  std::vector<double> weights;
  double sum = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(answer.count); ++i) {
    weights.push_back(answer.weight[i].shifted(-top).to_double());
    sum += weights.back();
  }
  for (double& w : weights) w /= sum;
  return weights;
}

void put_exact(nb::dict& out, const ExactAnswer& answer, const PosedBody& guest, bool guest_is_a) {
  if (!answer.shared) {
    const Vec3 d = direction_of(answer.direction);
    out["normal"] = row_of(guest_is_a ? d : -d);
    return;
  }
  const std::vector<double> weights = weights_of(answer);
  std::vector<std::int32_t> guests, hosts;
  Vec3 point;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    guests.push_back(answer.guest[i]);
    hosts.push_back(answer.host[i]);
    point = point + weights[i] * guest.pose.apply(guest.body->inner.points[static_cast<std::size_t>(answer.guest[i])]);
  }
  out["point"] = row_of(point);
  out["weights"] = output_array(weights, {weights.size()});
  out["vertices_a"] = output_array(guest_is_a ? guests : hosts, {weights.size()});
  out["vertices_b"] = output_array(guest_is_a ? hosts : guests, {weights.size()});
}

const char* name_of(Stage stage) {
  switch (stage) {
    case Stage::kCachedPlane:
      return "cached plane";
    case Stage::kCentreAxis:
      return "centre axis";
    case Stage::kSolver:
      return "solver";
    case Stage::kVertices:
      return "vertices";
    case Stage::kExact:
      return "exact";
  }
  return "";
}

}  // namespace

nb::dict counters_dict(const PairCounters& c) {
  nb::dict out;
  out["blocks"] = c.queries.blocks;
  out["exact_comparisons"] = c.queries.exact;
  out["guest_queries"] = c.guest_queries;
  out["host_queries"] = c.host_queries;
  out["games"] = c.games;
  out["rounds"] = c.rounds;
  return out;
}

nb::dict verdict_dict(const PairVerdict& verdict, const PosedBody& guest, const PosedBody& host, bool guest_is_a) {
  nb::dict out;
  out["shared"] = verdict.shared;
  out["stage"] = name_of(verdict.stage);
  if (verdict.exact) {
    put_exact(out, *verdict.exact, guest, guest_is_a);
  } else if (verdict.shared) {
    out["point"] = row_of(host.pose.apply(host.body->centre + verdict.certificate.x));
  } else {
    const Vec3 d = verdict.stage == Stage::kVertices ? verdict.direction : host.pose.rotate(verdict.certificate.q);
    out["normal"] = row_of(guest_is_a ? d : -d);
  }
  return out;
}

}  // namespace plannercheck
