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

// A ball in the field's frame, with room for all that errs.
struct Reach {
  Vec3 centre;
  double length;
};

class Look {
 public:
  Look(const PosedPolytope& body, const PosedPolytope& field)
      : body_(body),
        field_(field),
        lattice_(field.body->as<PartSet>().lattice()),
        inflated_(body.body->inflation_radius + field.body->inflation_radius),
        error_((norm_1(body.pose.translation()) + norm_1(field.pose.translation()) + 2 * body.body->origin_radius +
                inflated_) *
                   kLookError +
               norm_1(lattice_.corner) * kLatticeError + kDenormalError) {}

  Answer run() {
    std::array<Reach, kMostCoveringBalls> open;  // not under their ceilings' cells
    std::size_t count = 0;
    for (const SmallBall& ball : body_.body->covering_balls()) {
      const Reach own{in_field(ball.centre), (ball.radius + inflated_) * (1 + kLookError) + error_};
      if (!std::isfinite(norm_1(own.centre) + own.length)) return Answer::kUndecided;
      if (!(own.centre.z - own.length > ceiling(own))) open[count++] = own;
    }
    for (std::size_t k = 0; k < count; ++k) fetch(window(open[k]));
    if (count == 0) return Answer::kSeparated;
    const Vec3 down = -body_.pose.rotate_back(field_.pose.rotate({0, 0, 1}));
    QueryCounters counters;
    const std::int32_t vertex = extreme(body_.body->inner, down, counters);
    const Vec3 lowest = in_field(body_.body->inner.points[at(vertex)]);
    if (is_under_surface(lowest - Vec3{0, 0, inflated_ * (1 - kLookError)})) return Answer::kShared;
    const double bottom = lowest.z - inflated_ * (1 + kLookError) - error_;
    for (std::size_t k = 0; k < count; ++k) {
      if (!is_over_all(open[k], bottom)) return Answer::kUndecided;
    }
    return Answer::kSeparated;
  }

 private:
  const PosedPolytope &body_, &field_;
  const PartSet::Lattice lattice_;
  double inflated_, error_;  // `error_`: of places in the field's frame

  Vec3 in_field(Vec3 p) const { return field_.pose.rotate_back(body_.pose.apply(p) - field_.pose.translation()); }

  // How high any prism is that is less than `length` from the centre along x and along y, by the finest cells that are
  // as wide (height_ceilings.hpp).
  double ceiling(const Reach& reach) const {
    const HeightCeilings& all = field_.body->as<PartSet>().ceilings();
    auto level = all.levels().begin();
    while (level + 1 != all.levels().end() && !(smaller(level->width[0], level->width[1]) > reach.length)) ++level;
    std::array<std::int32_t, 2> cell;
    for (std::size_t i = 0; i < 2; ++i) {
      const int axis = static_cast<int>(i);
      const double place = (reach.centre[axis] - lattice_.corner[axis]) / level->width[i];
      cell[i] = static_cast<std::int32_t>(smaller(larger(place, 0), level->cells[i] - 1));
    }
    const std::int32_t place = level->first + HeightCeilings::place(cell[0], cell[1], level->tiles);
    return lattice_.corner.z + all.unit() * all.values()[place];
  }

  // All rows are asked for before the first one is waited for.
  void fetch(const Window& window) const {
    if (window.count > kMostHeights) return;
    for (std::size_t i = window.from[0]; i < window.past[0]; ++i) {
      const double* const row = lattice_.heights + i * lattice_.size[1];
      __builtin_prefetch(row + window.from[1]), __builtin_prefetch(row + window.past[1] - 1);
    }
  }

  // Of all squares that are nearer to the centre than `length`, along x and along y.
  Window window(const Reach& reach) const {
    Window out;
    out.is_inside = true, out.count = 1;
    for (std::size_t i = 0; i < 2; ++i) {
      const int axis = static_cast<int>(i);
      const double along = reach.centre[axis] - lattice_.corner[axis], last = static_cast<double>(lattice_.size[i] - 1);
      const double from = std::floor((along - reach.length) / lattice_.step[i]);
      const double to = std::floor((along + reach.length) / lattice_.step[i]) + 1;
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
    const Window near = window({p, error_});
    return near.is_inside && near.count <= kMostHeights && p.z - error_ > lattice_.corner.z &&
           all(near, [&](double height) { return height > p.z + error_; });
  }

  // Whether a ball, of whose points none counts that is below `bottom`, is over all heights around it. A comparison
  // with one that is missing is false.
  bool is_over_all(const Reach& ball, double bottom) const {
    const double least = larger(ball.centre.z - ball.length, bottom);
    const Window near = window(ball);
    if (near.count == 0) return true;
    return near.count <= kMostHeights && least > lattice_.corner.z &&
           all(near, [&](double height) { return !(height >= least); });
  }
};

}  // namespace

Answer look_at_heights(const PosedPolytope& body, const PosedPolytope& field) { return Look(body, field).run(); }

}  // namespace plannercheck
