// Filters that settle intervals of a motion in lanes, and the quantities that they and the exact steps compare.
//
// In: a grid of states, bounds of the bodies' motion, pairs. Out: for each pair the intervals that bounding spheres and
// boxes leave open, one bit each. Each filter proves the bodies apart throughout an interval, by the chords of centres
// or by one direction at both ends (see motion_certifier.hpp). In doubt a filter leaves the interval open.
#pragma once

#include <array>
#include <vector>

#include "bodies/half_space.hpp"
#include "motions/adaptive_subdivision.hpp"
#include "motions/link_bounds.hpp"
#include "motions/motion_certifier.hpp"
#include "motions/motion_grid.hpp"
#include "motions/motion_rounding.hpp"

namespace plannercheck {

// Bodies' poses are off rigid by at most 3.6e-6 (plannercheck/robots/unit_lengths.py), so they stretch by half of that.
inline constexpr double kStretch = 1 + 2e-6;

// The radius of the sphere around a body's centre.
inline double sphere_radius(const Polytope& body) { return (body.radius + body.inflation_radius) * kStretch; }

// An open pair with a direction taken from its bounds, in the pair's frame, from b to a.
struct DirectedPair : OpenPair {
  Vec3 direction;
};

class MotionFilters {
 public:
  // `defects`: how far the placements of static bodies are off rigid.
  MotionFilters(const MotionModel& model, const std::vector<double>& defects, MotionGrid& grid,
                const ChainBounds& bounds)
      : model_(model), defects_(defects), grid_(grid), bounds_(bounds) {}

  // Sets the bound of all rounding, m, and that of the coordinates involved.
  void set_rounding(const MotionRounding& rounding) { slack_ = rounding.slack, size_ = rounding.size; }
  double slack() const { return slack_; }

  const CertifiedPair& pair(std::int32_t index) const { return model_.pairs[static_cast<std::size_t>(index)]; }
  const Polytope& body(std::int32_t index) const { return *model_.bodies[static_cast<std::size_t>(index)].body; }
  bool stands_still(std::int32_t index) const { return model_.bodies[static_cast<std::size_t>(index)].link < 0; }

  double speed(const CertifiedPair& pair) const { return bounds_.speed(pair.chain_a) + bounds_.speed(pair.chain_b); }
  // How far a tube shifts points of both bodies.
  double shift(const CertifiedPair& pair) const { return bounds_.shift(pair.chain_a) + bounds_.shift(pair.chain_b); }
  // ε: how far points may leave their chords within an interval, the tube included.
  double chord_deviation(Deviation by) const { return by.curvature * grid_.step() * grid_.step() / 8 + by.shift; }
  double chord_deviation(const CertifiedPair& pair) const {
    return chord_deviation(bounds_.deviation(pair.chain_a) + bounds_.deviation(pair.chain_b));
  }
  double inflation_radii(const CertifiedPair& pair) const {
    return (body(pair.a).inflation_radius + body(pair.b).inflation_radius) * kStretch;
  }
  // An interval is settled if the hulls are further apart than this along one direction at both ends.
  double apart(const CertifiedPair& pair) const { return chord_deviation(pair) + inflation_radii(pair) + slack_; }

  unsigned all_intervals() const { return (1U << grid_.intervals()) - 1; }

  // The box around the whole path of a body, given its chain from the world, rounded outwards: the high corner, then
  // the low one with its sign changed.
  Floats box_around_path(std::int32_t body, std::int32_t chain) const;
  // The same for a ball, given the rows of its centre, and its radius with the shift by a tube.
  Floats box_around_path(const double* centre, double radius, double curvature) const;
  // The intervals that bounding spheres on chords leave open, against each other or against the box of a static body.
  unsigned near(const CertifiedPair& pair) const;
  // The same against a half-space, given by its plane.
  unsigned near_plane(const CertifiedPair& pair, const WorldPlane& plane) const;
  // Settles the intervals whose boxes are apart along a direction of the frame, by `beyond` more than needed; records
  // at which end of those left open the gap along it is least.
  void boxes_settle(DirectedPair& found, Vec3 direction, double beyond = 0);
  // Whether the boxes of two links are further apart than the limit along a direction of a frame, at all states.
  bool are_apart(const LinkBox& a, const LinkBox& b, std::int32_t frame, Vec3 direction, double limit) const;
  // A first direction for them, as `between`.
  Vec3 between(const LinkBox& a, const LinkBox& b, std::int32_t frame, std::size_t state) const;
  // A first direction, of length 1 up to rounding: out of b's box if a's centre is outside, else between the centres.
  Vec3 between(const CertifiedPair& pair, std::size_t state);
  PosedPair posed(const CertifiedPair& pair, std::size_t state);

 private:
  const MotionModel& model_;
  const std::vector<double>& defects_;
  MotionGrid& grid_;
  const ChainBounds& bounds_;
  double slack_ = 0, size_ = 0;

  // The end of the states, in whole lanes. Loops over intervals go backwards from here, so that the next states are
  // still in registers.
  std::size_t past_blocks() const { return (grid_.intervals() / kStep + 1) * kStep; }
  unsigned chord_meets_box(const CertifiedPair& pair, double apart) const;
  bool spheres_come_near(const CertifiedPair& pair, double sum) const;
  unsigned chord_meets_sphere(const CertifiedPair& pair, double sum) const;
};

}  // namespace plannercheck
