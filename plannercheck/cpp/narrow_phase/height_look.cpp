#include "narrow_phase/height_look.hpp"

#include <array>
#include <cmath>

#include "narrow_phase/support.hpp"

namespace plannercheck {
namespace {

// Of places in the field's frame: poses are off rigid by at most δ = 3.6e-6, so that Mᵀ in place of M⁻¹ errs by δ (1 +
// δ) of what it turns, also where it finds the lowest vertex; and radii are stretched by half of δ. Rounding is far
// below the rest.
constexpr double kLookError = 1e-5;

// Of the lattice's own coordinates, and of indices: a few roundings of doubles.
constexpr double kLatticeError = 0x1p-45;

// More heights under a ball than that are not looked at: a tree is faster (a ball as wide as 30 steps).
constexpr double kMostHeights = 1024;

// Heights from i, j up to and with the last ones; none if `from` is beyond `to`.
struct Window {
  std::array<std::size_t, 2> from{}, past{};
  bool is_inside = false;  // whether all of its squares are there
  double count = 0;
};

class Look {
 public:
  Look(const PosedPolytope& body, const PosedPolytope& field)
      : body_(body),
        field_(field),
        lattice_(field.body->parts->lattice()),
        inflated_(body.body->inflation_radius + field.body->inflation_radius),
        error_((norm_1(body.pose.translation()) + norm_1(field.pose.translation()) + 2 * body.body->origin_radius +
                inflated_) *
                   kLookError +
               norm_1(lattice_.corner) * kLatticeError + kDenormalError) {}

  Answer run() {
    const Vec3 down = -body_.pose.rotate_back(field_.pose.rotate({0, 0, 1}));
    QueryCounters counters;
    const std::int32_t vertex = extreme(body_.body->inner, down, counters);
    const Vec3 lowest = in_field(body_.body->inner.points[at(vertex)]);
    if (!std::isfinite(norm_1(lowest) + error_)) return Answer::kUndecided;
    if (is_under_surface(lowest)) return Answer::kShared;
    const double bottom = lowest.z - inflated_ * (1 + kLookError) - error_;
    for (const SmallBall& ball : body_.body->covering_balls()) {
      if (!is_over_all(in_field(ball.centre), (ball.radius + inflated_) * (1 + kLookError) + error_, bottom))
        return Answer::kUndecided;
    }
    return Answer::kSeparated;
  }

 private:
  const PosedPolytope &body_, &field_;
  const PartSet::Lattice lattice_;
  double inflated_, error_;  // `error_`: of places in the field's frame

  Vec3 in_field(Vec3 p) const { return field_.pose.rotate_back(body_.pose.apply(p) - field_.pose.translation()); }

  // Of all squares that are nearer to a place than `reach`, along x and along y.
  Window window(Vec3 p, double reach) const {
    Window out;
    out.is_inside = true, out.count = 1;
    for (std::size_t i = 0; i < 2; ++i) {
      const int axis = static_cast<int>(i);
      const double along = p[axis] - lattice_.corner[axis], last = static_cast<double>(lattice_.size[i] - 1);
      const double from = std::floor((along - reach) / lattice_.step[i]);
      const double to = std::floor((along + reach) / lattice_.step[i]) + 1;
      out.is_inside &= from >= 0 && to <= last;
      if (!(to >= 0 && from <= last)) return {};
      out.from[i] = static_cast<std::size_t>(larger(from, 0));
      out.past[i] = static_cast<std::size_t>(smaller(to, last)) + 1;
      out.count *= static_cast<double>(out.past[i] - out.from[i]);
    }
    return out;
  }

  template <class Holds>
  bool all(const Window& window, Holds holds) const {
    for (std::size_t i = window.from[0]; i < window.past[0]; ++i) {
      const double* const row = lattice_.heights + i * lattice_.size[1];
      for (std::size_t j = window.from[1]; j < window.past[1]; ++j) {
        if (!holds(row[j])) return false;
      }
    }
    return true;
  }

  // Below all heights around it, none of which is missing, and above the base: in a prism, wherever it is exactly.
  bool is_under_surface(Vec3 p) const {
    const Window near = window(p, error_);
    return near.is_inside && near.count <= kMostHeights && p.z - error_ > lattice_.corner.z &&
           all(near, [&](double height) { return height > p.z + error_; });
  }

  // Whether a ball, of whose points none counts that is below `bottom`, is over all heights around it. A comparison
  // with one that is missing is false.
  bool is_over_all(Vec3 centre, double reach, double bottom) const {
    if (!std::isfinite(norm_1(centre) + reach)) return false;
    const double least = larger(centre.z - reach, bottom);
    const Window near = window(centre, reach);
    if (near.count == 0) return true;
    return near.count <= kMostHeights && least > lattice_.corner.z &&
           all(near, [&](double height) { return !(height >= least); });
  }
};

}  // namespace

Answer look_at_heights(const PosedPolytope& body, const PosedPolytope& field) { return Look(body, field).run(); }

}  // namespace plannercheck
