// The face's trajectories: each piece is a curve, judged by the pairs that can meet where it is
// (plannercheck/motions/trajectory_checks.py).
#include <algorithm>
#include <cmath>

#include "library/checker_impl.hpp"

namespace plannercheck {
namespace {

// The highest degree of a piece (plannercheck/trajectories/curve.py).
constexpr std::size_t kMostDegreeOfPiece = 20;

// A trajectory for one checker: where the control points of each piece begin, its tube, and the pairs that judge it.
struct JudgedTrajectory {
  std::vector<std::size_t> first;
  std::vector<double> tube;  // (nq + 1)
  std::vector<Table> tables;

  JudgedTrajectory(const Trajectory& given, const Checker& checker, const PreparedCell& cell,
                   std::span<const double> around) {
    check_shape(given, checker);
    set_tube(given, around, cell);
    for (std::size_t k = 0; k < given.degrees.size(); ++k) tables.push_back(table_of_piece(given, cell, k));
  }

  Segments from(const Trajectory& given, std::size_t piece) const {
    const std::size_t width = tube.size() - 1, degree = given.degrees[piece];
    const double* const points = given.points.data() + first[piece];
    return {points, points + degree * width, (degree + 1) * width, degree, tube.data(), 0};
  }

 private:
  void check_shape(const Trajectory& given, const Checker& checker) {
    const std::size_t width = checker.nq(), count = given.degrees.size();
    if (checker.joint_names().size() != width)
      throw CallError("joints of " + checker.robot_name() + " take several numbers: check its trajectories in Python");
    std::size_t past = 0;
    for (const std::size_t degree : given.degrees) {
      if (degree < 1 || degree > kMostDegreeOfPiece)
        throw CallError("a piece's degree must be 1 to 20, not " + std::to_string(degree));
      first.push_back(past);
      past += (degree + 1) * width;
    }
    if (count == 0 || given.breaks.size() != count + 1 || given.points.size() != past || given.error.size() != width)
      throw CallError("a trajectory of " + std::to_string(count) + " pieces has " + std::to_string(count + 1) +
                      " breaks, " + std::to_string(past) + " numbers of control points and " + std::to_string(width) +
                      " errors");
    for (std::size_t k = 0; k < count; ++k) {
      if (!(given.breaks[k + 1] > given.breaks[k]))
        throw CallError("breaks must grow, s, from piece " + std::to_string(k));
      if (k > 0 && !std::equal(given.points.begin() + static_cast<std::ptrdiff_t>(first[k] - width),
                               given.points.begin() + static_cast<std::ptrdiff_t>(first[k]),
                               given.points.begin() + static_cast<std::ptrdiff_t>(first[k])))
        throw CallError("pieces " + std::to_string(k - 1) + " and " + std::to_string(k) +
                        " do not meet: no robot can jump");
    }
  }

  void set_tube(const Trajectory& given, std::span<const double> around, const PreparedCell& cell) {
    const std::size_t width = given.error.size();
    if (!around.empty() && around.size() != width)
      throw CallError("tube must be " + std::to_string(width) + " numbers, or none");
    for (std::size_t c = 0; c < width; ++c) {
      const double asked = around.empty() ? 0 : around[c];
      for (const double off : {asked, given.error[c]}) {
        if (!(off >= 0 && off <= cell.largest_value))
          throw CallError("tube and error must be at least 0, rad and m, not " + listed({&off, 1}));
      }
      tube.push_back((asked + given.error[c]) * (1 + 0x1p-52));
    }
    tube.push_back(0);
  }

  Table table_of_piece(const Trajectory& given, const PreparedCell& cell, std::size_t piece) const {
    const std::size_t width = cell.width();
    bool within = true;
    for (std::size_t c = 0; c < width; ++c) {
      double least = given.points[first[piece] + c], largest = least;
      for (std::size_t row = 0; row <= given.degrees[piece]; ++row) {
        const double x = given.points[first[piece] + row * width + c];
        least = std::min(least, x), largest = std::max(largest, x);
        if (!(std::fabs(x) <= cell.largest_value))
          throw CallError("piece " + std::to_string(piece) + ": control points must be finite");
      }
      least -= tube[c], largest += tube[c];
      if (least < cell.usual_low[c] || largest > cell.usual_high[c]) refuse_range(cell, "piece", piece, c);
      within &= least >= cell.lower[c] && largest <= cell.upper[c];
    }
    return within || !cell.has_limits ? Table::kWithinLimits : Table::kAll;
  }
};

// The number that each row of some array has at a joint.
class JointRows {
 public:
  JointRows(const char* what, std::span<const double> numbers, std::size_t count, std::size_t width)
      : numbers_(numbers), width_(width) {
    if (numbers.size() != count * width)
      throw CallError(std::string(what) + " must have shape (" + std::to_string(count) + ", " + std::to_string(width) +
                      "), not " + std::to_string(numbers.size()) + " numbers");
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (!std::isfinite(numbers[i]))
        throw CallError(std::string(what) + " must be finite: point " + std::to_string(i / width) + " has " +
                        listed({&numbers[i], 1}));
    }
  }
  double at(std::size_t row, std::size_t column) const { return numbers_[row * width_ + column]; }

 private:
  std::span<const double> numbers_;
  std::size_t width_;
};

// Times in s as whole nanoseconds, if they are those of a message (plannercheck/trajectories/stamps.py).
std::vector<double> durations(std::span<const double> times) {
  std::vector<double> stamps, out;
  bool exact = true;
  for (const double time : times) {
    stamps.push_back(std::nearbyint(time * 1e9));
    exact &= stamps.back() / 1e9 == time && std::fabs(stamps.back()) < 0x1p53;
  }
  for (std::size_t k = 0; k + 1 < times.size(); ++k)
    out.push_back(exact ? (stamps[k + 1] - stamps[k]) / 1e9 : times[k + 1] - times[k]);
  return out;
}

// What both ends of a segment of duration h have in one column.
struct Ends {
  double p, q, v, w, a, b, h;
};

// A column of its control points, and how far they and the controller's own doubles may be off
// (plannercheck/trajectories/controllers.py, rounding.py).
std::vector<double> control_points(const Ends& e, std::size_t degree) {
  const double fifth = e.h / 5, twentieth = e.h * e.h / 20;
  if (degree == 1) return {e.p, e.q};
  if (degree == 3) return {e.p, e.p + e.v * (e.h / 3), e.q - e.w * (e.h / 3), e.q};
  return {e.p,
          e.p + e.v * fifth,
          e.p + 2 * e.v * fifth + e.a * twentieth,
          e.q - 2 * e.w * fifth + e.b * twentieth,
          e.q - e.w * fifth,
          e.q};
}

double rounding_of(const Ends& e, std::size_t degree) {
  constexpr double kUnit = 0x1p-53;
  const double p = std::fabs(e.p), r = std::fabs(e.q), v0 = std::fabs(e.v) * e.h, v1 = std::fabs(e.w) * e.h,
               a0 = std::fabs(e.a) * e.h * e.h, a1 = std::fabs(e.b) * e.h * e.h;
  const double largest = std::max(p, r) + 0.4 * std::max(v0, v1) + std::max(a0, a1) / 20;
  const double control = 8 * kUnit * largest;
  const double error = degree == 1   ? 7 * kUnit * (p + r)
                       : degree == 3 ? control + 22 * kUnit * (6 * p + 5 * r + 4 * v0 + 2 * v1)
                                     : control + 37 * kUnit * (32 * p + 31 * r + 18 * v0 + 14 * v1 + 4 * a0 + 2 * a1);
  return error > 0 ? error * (1 + 0x1p-30) + 1e-270 : 0;
}

void check_points(std::span<const double> times, std::size_t width, std::span<const double> velocities,
                  std::span<const double> accelerations) {
  if (times.size() < 2 || width == 0) throw CallError("a trajectory takes at least two points, of numbers");
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!std::isfinite(times[k]) || times[k] < 0 || (k > 0 && times[k] - times[k - 1] < 0.9e-9))
      throw CallError("times must grow from 0 s on, by 1 ns at least, but point " + std::to_string(k) + " is at " +
                      listed({&times[k], 1}) + " s");
  }
  if (velocities.empty() && !accelerations.empty())
    throw CallError("points have accelerations without velocities: joint_trajectory_controller would command 0");
  for (const double last : velocities.last(velocities.empty() ? 0 : width)) {
    if (std::fabs(last) > 0x1p-23)
      throw CallError(
          "the last point moves: joint_trajectory_controller refuses a trajectory that does not end at rest");
  }
}

}  // namespace

Result<Trajectory> Trajectory::executed(std::span<const double> times, std::span<const double> positions,
                                        std::span<const double> velocities,
                                        std::span<const double> accelerations) noexcept {
  return guarded<Trajectory>([&] {
    const std::size_t n = times.size(), width = n == 0 ? 0 : positions.size() / n;
    const JointRows q("positions", positions, n, width), v("velocities", velocities, velocities.empty() ? 0 : n, width),
        a("accelerations", accelerations, accelerations.empty() ? 0 : n, width);
    check_points(times, width, velocities, accelerations);
    const std::size_t degree = velocities.empty() ? 1 : accelerations.empty() ? 3 : 5;
    const std::vector<double> steps = durations(times);
    Trajectory out{{times.begin(), times.end()}, std::vector<std::size_t>(n - 1, degree), {}, {}};
    out.points.resize((n - 1) * (degree + 1) * width), out.error.resize(width);
    for (std::size_t k = 0; k + 1 < n; ++k) {
      for (std::size_t c = 0; c < width; ++c) {
        Ends ends{q.at(k, c), q.at(k + 1, c), 0, 0, 0, 0, steps[k]};
        if (degree > 1) ends.v = v.at(k, c), ends.w = v.at(k + 1, c);
        if (degree > 3) ends.a = a.at(k, c), ends.b = a.at(k + 1, c);
        const std::vector<double> column = control_points(ends, degree);
        for (std::size_t row = 0; row <= degree; ++row) out.points[(k * (degree + 1) + row) * width + c] = column[row];
        out.error[c] = std::max(out.error[c], rounding_of(ends, degree));
      }
    }
    return out;
  });
}

Result<bool> Checker::check_trajectory(const Trajectory& trajectory, Workspace& workspace, std::span<const double> tube,
                                       double tolerance) const noexcept {
  return guarded<bool>([&] {
    check_tolerance(tolerance);
    const JudgedTrajectory judged(trajectory, *this, *impl_->cell, tube);
    Workspace::State& state = state_of(workspace);
    const std::size_t count = judged.tables.size();
    state.answers.resize(count);
    for (std::size_t k = 0, past = 0; k < count; k = past) {  // those of one degree and table at once
      const auto is_alike = [&](std::size_t other) {
        return trajectory.degrees[other] == trajectory.degrees[k] && judged.tables[other] == judged.tables[k];
      };
      for (past = k + 1; past < count && is_alike(past); ++past) {
      }
      if (!chained(*impl_->cell, judged.tables[k]).touching.empty()) return false;
      impl_->engine().check_motions(judged.tables[k], judged.from(trajectory, k), past - k, tolerance,
                                    state.answers.data() + k, *state.scratch);
      for (std::size_t i = k; i < past; ++i) {
        const auto answer = static_cast<MotionAnswer>(state.answers[i]);
        check_precise(answer, "piece", i, tolerance);
        if (answer != MotionAnswer::kFree) return false;
      }
    }
    return true;
  });
}

Result<MotionVerdict> Checker::explain_trajectory(const Trajectory& trajectory, Workspace& workspace,
                                                  std::span<const double> tube, double tolerance) const noexcept {
  return guarded<MotionVerdict>([&] {
    check_tolerance(tolerance);
    const JudgedTrajectory judged(trajectory, *this, *impl_->cell, tube);
    Workspace::State& state = state_of(workspace);
    for (std::size_t k = 0; k < judged.tables.size(); ++k) {
      const double start = trajectory.breaks[k], end = trajectory.breaks[k + 1];
      const auto time = [&](double s) { return s < 0 ? -1 : std::min(start + (end - start) * s, end); };
      const std::vector<std::int32_t>& touching = chained(*impl_->cell, judged.tables[k]).touching;
      if (!touching.empty()) return MotionVerdict{false, start, -1, impl_->named(at(touching[0]))};
      const MotionReport report =
          impl_->engine().explain_motion(judged.tables[k], judged.from(trajectory, k)[0], tolerance, *state.scratch);
      check_precise(report.answer, "piece", k, tolerance);
      if (report.answer != MotionAnswer::kFree)
        return MotionVerdict{false, time(report.free_until), time(report.refused), impl_->named(at(report.pair))};
    }
    return MotionVerdict{true, trajectory.breaks.back(), -1, {}};
  });
}

}  // namespace plannercheck
