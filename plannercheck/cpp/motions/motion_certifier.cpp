#include "motions/motion_certifier.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "motions/motion_filters.hpp"

namespace plannercheck {
namespace {

// How far a body's points, centre and sphere lie from the frame that its placement refers to, m.
double size_of(const GeometryObject& object) {
  const double far = norm_1(object.placement.translation()) + object.body->origin_radius * kStretch;
  return far + object.body->origin_radius + 2 * sphere_radius(*object.body);
}

}  // namespace

MotionCertifier::MotionCertifier(MotionModel model, bool hints) : model_(std::move(model)), hints_(hints) {
  std::vector<bool> used(model_.bodies.size(), false);
  for (std::size_t p = 0; p < model_.pairs.size(); ++p) {
    const CertifiedPair& pair = model_.pairs[p];
    used[at(pair.a)] = used[at(pair.b)] = true;
    if (pair.frame >= 0) frames_.push_back(pair.frame);
    if (model_.bodies[at(pair.b)].link >= 0) among_self_.push_back(static_cast<std::int32_t>(p));
  }
  for (std::size_t b = 0; b < used.size(); ++b) {
    if (used[b]) (model_.bodies[b].link >= 0 ? movers_ : still_).push_back(static_cast<std::int32_t>(b));
  }
  for (const std::int32_t mover : movers_) mounted_size_ = larger(mounted_size_, size_of(model_.bodies[at(mover)]));
  for (const GeometryObject& body : model_.bodies) defects_.push_back(rigidity_defect(body.placement) + 16 * 0x1p-53);
  bound_still();
}

void MotionCertifier::bound_still() {
  still_row_ = (still_.size() + kStep - 1) / kStep * kStep;
  still_bounds_.assign(6 * still_row_, std::numeric_limits<double>::infinity());
  std::vector<std::int32_t> position(model_.bodies.size(), -1);
  for (std::size_t s = 0; s < still_.size(); ++s) {
    const GeometryObject& object = model_.bodies[at(still_[s])];
    position[at(still_[s])] = static_cast<std::int32_t>(s);
    still_size_ = larger(still_size_, size_of(object));
    for (std::size_t k = 0; k < 3; ++k) {
      double &low = still_bounds_[k * still_row_ + s], &high = still_bounds_[(k + 3) * still_row_ + s];
      high = -low;
      for (const Vec3& v : object.body->inner.points) {
        const Vec3 p = object.placement.apply(v);
        low = smaller(low, p[static_cast<int>(k)]), high = larger(high, p[static_cast<int>(k)]);
      }
      low -= object.body->inflation_radius, high += object.body->inflation_radius;
    }
  }
  pair_of_.assign(movers_.size() * still_row_, -1);
  chain_in_world_.assign(movers_.size(), -1);
  for (std::size_t p = 0; p < model_.pairs.size(); ++p) {
    const CertifiedPair& pair = model_.pairs[p];
    if (position[at(pair.b)] < 0) continue;
    const auto m = static_cast<std::size_t>(std::lower_bound(movers_.begin(), movers_.end(), pair.a) - movers_.begin());
    pair_of_[m * still_row_ + at(position[at(pair.b)])] = static_cast<std::int32_t>(p);
    chain_in_world_[m] = pair.chain_a;
  }
}

// The pairs of a mover with static bodies and whose boxes meet the given box.
void MotionCertifier::find_near(std::size_t mover, Vec3 low, Vec3 high, std::vector<std::int32_t>& found) const {
  const std::int32_t* pairs = &pair_of_[mover * still_row_];
  for (std::size_t first = 0; first < still_row_; first += kStep) {
    LaneMask apart{};
    for (std::size_t k = 0; k < 3; ++k) {
      const int axis = static_cast<int>(k);
      apart |= load_lanes(&still_bounds_[k * still_row_ + first]) > broadcast(high[axis]);
      apart |= load_lanes(&still_bounds_[(k + 3) * still_row_ + first]) < broadcast(low[axis]);
    }
    for (unsigned meet = ~bits(apart) & ((1U << kLanes) - 1); meet != 0; meet &= meet - 1) {
      const std::int32_t pair = pairs[first + static_cast<std::size_t>(__builtin_ctz(meet))];
      if (pair >= 0) found.push_back(pair);
    }
  }
}

void MotionCertifier::states(const double* q0, const double* q1, const double* t, std::size_t n, double* q) const {
  ConfigurationPath path(at(model_.width), model_.parts);
  path.set(q0, q1);
  std::vector<double> columns(at(model_.width) * n);
  path.at(t, n, n, columns.data());
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < at(model_.width); ++c) q[i * at(model_.width) + c] = columns[c * n + i];
  }
}

}  // namespace plannercheck
