#include "motions/motion_certifier.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "bodies/half_space.hpp"
#include "broad_phase/part_clearances.hpp"
#include "motions/motion_collisions.hpp"
#include "motions/motion_filters.hpp"
#include "motions/motion_screen.hpp"

namespace plannercheck {
namespace {

// How far a body's points, centre and sphere extend from the frame of its placement, m.
double size_of(const GeometryObject& object) {
  if (!object.body->traits().is_bounded) {  // of which only the plane enters
    const HalfSpace& h = object.body->as<HalfSpace>();
    return norm_1(object.placement.translation()) + 2 * std::fabs(h.offset) / norm_max(h.normal) +
           2 * object.body->inflation_radius * kStretch;
  }
  const double far = norm_1(object.placement.translation()) + object.body->origin_radius * kStretch;
  return far + object.body->origin_radius + 2 * sphere_radius(*object.body);
}

}  // namespace

MotionCertifier::MotionCertifier(MotionModel model, const Tuning& tuning, std::shared_ptr<const CheckerCore> states)
    : model_(std::move(model)), tuning_(tuning), states_(std::move(states)) {
  std::vector<std::int32_t> place;
  model_.chains = sorted_chains(model_.chains, place);
  for (CertifiedPair& pair : model_.pairs) {
    if (pair.chain_a >= 0) pair.chain_a = place[at(pair.chain_a)];
    if (pair.chain_b >= 0) pair.chain_b = place[at(pair.chain_b)];
    pair.kind = kind_of(*model_.bodies[at(pair.a)].body, *model_.bodies[at(pair.b)].body);
  }
  std::vector<bool> used(model_.bodies.size(), false);
  for (const CertifiedPair& pair : model_.pairs) {
    used[at(pair.a)] = used[at(pair.b)] = true;
    for (const std::int32_t body : {pair.a, pair.b}) has_parts_ |= model_.bodies[at(body)].body->traits().has_parts;
    if (pair.frame >= 0) frames_.push_back(pair.frame);
  }
  std::vector<std::int32_t> still;
  for (std::size_t b = 0; b < used.size(); ++b) {
    if (used[b]) (model_.bodies[b].link >= 0 ? movers_ : still).push_back(static_cast<std::int32_t>(b));
  }
  for (const std::int32_t body : movers_) mounted_size_ = larger(mounted_size_, size_of(model_.bodies[at(body)]));
  for (const std::int32_t body : still) still_size_ = larger(still_size_, size_of(model_.bodies[at(body)]));
  for (const GeometryObject& body : model_.bodies) defects_.push_back(rigidity_defect(body.placement) + 16 * 0x1p-53);
  chain_table_ = std::make_shared<const ChainTable>(model_.chains);
  const auto is_unbounded = [&](std::int32_t body) { return !model_.bodies[at(body)].body->traits().is_bounded; };
  still.erase(std::remove_if(still.begin(), still.end(), is_unbounded), still.end());
  screen_ = std::make_shared<const MotionScreen>(model_, movers_, still);
  collisions_ = std::make_shared<const MotionCollisions>(model_);
  const double travel = std::accumulate(model_.travel.begin(), model_.travel.end(), 0.0);
  clearances_ = std::make_shared<const PartClearances>(model_.bodies, model_.extent + travel + mounted_size_);
}

void MotionCertifier::states(const Segment& motion, const double* t, std::size_t n, double* q) const {
  Path path(at(model_.width), model_.parts);
  path.set(motion);
  std::vector<double> columns(at(model_.width) * n);
  path.at(t, n, n, columns.data());
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < at(model_.width); ++c) q[i * at(model_.width) + c] = columns[c * n + i];
  }
}

}  // namespace plannercheck
