// The face's trajectories: each piece is a curve, judged by the pairs that can meet where it is
// (plannercheck/motions/trajectory_checks.py).
#include <algorithm>
#include <cmath>

#include "library/checker_impl.hpp"

namespace plannercheck {
namespace {

// The highest degree of a piece (plannercheck/trajectories/curve.py).
constexpr std::size_t kMostDegreeOfPiece = 20;

// The shortest piece, s (plannercheck/trajectories/curve.py), and the fastest end that joint_trajectory_controller
// takes for rest, rad/s and m/s.
constexpr double kShortest = 0.9e-9, kRest = 0x1p-23;

// So much of a tube that is none is shown (plannercheck/motions/trajectory_checks.py).
constexpr std::size_t kMostOfTube = 80;

std::string numbered(const char* what, std::size_t k) { return what + (' ' + std::to_string(k)); }

void check_durations(std::span<const double> breaks) {
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    if (!(breaks[k + 1] - breaks[k] >= kShortest))
      throw CallError(numbered("piece", k) + " takes " + rounded(breaks[k + 1] - breaks[k], 3) + " s, less than 1 ns");
  }
}

void check_finite(const char* what, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i]))
      throw CallError(std::string(what) + " must be finite: " + numbered("number", i) + " is " + shown(numbers[i]));
  }
}

std::string named_piece(const Trajectory& trajectory, std::size_t k) {
  return numbered("piece", k) + " of the trajectory, " + rounded(trajectory.breaks[k], 6) + " to " +
         rounded(trajectory.breaks[k + 1], 6) + " s";
}

// A trajectory for one checker: where the control points of each piece begin, its tube, and the pairs that judge it.
struct JudgedTrajectory {
  std::vector<std::size_t> first;
  std::vector<double> tube;  // (nq + 1)
  std::vector<Table> tables;

  JudgedTrajectory(const Trajectory& given, const Checker& checker, const PreparedCell& cell,
                   std::span<const double> around) {
    check_shape(given, checker, cell);
    set_tube(given, around, cell);
    for (std::size_t k = 0; k < given.degrees.size(); ++k) tables.push_back(table_of_piece(given, cell, k));
  }

  Segments from(const Trajectory& given, std::size_t piece) const {
    const std::size_t width = tube.size() - 1, degree = given.degrees[piece];
    const double* const points = given.points.data() + first[piece];
    return {points, points + degree * width, (degree + 1) * width, degree, tube.data(), 0};
  }

 private:
  void check_shape(const Trajectory& given, const Checker& checker, const PreparedCell& cell) {
    const std::size_t width = checker.nq(), count = given.degrees.size();
    if (checker.joint_names().size() != width)
      throw CallError("joints of " + checker.robot_name() + " take several numbers: check its trajectories in Python");
    if (given.error.empty() && width > 0)
      throw CallError("the trajectory has no errors: give " + std::to_string(width) +
                      " numbers, zeros where its control points are exact");
    if (given.error.size() != width)
      throw CallError("the trajectory has " + std::to_string(given.error.size()) + " columns, but " + cell.columns);
    std::size_t past = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t degree = given.degrees[k];
      if (degree < 1 || degree > kMostDegreeOfPiece)
        throw CallError(numbered("piece", k) + " must have 2 to " + std::to_string(kMostDegreeOfPiece + 1) +
                        " control points, not " + std::to_string(degree + 1));
      first.push_back(past);
      past += (degree + 1) * width;
    }
    if (count == 0) throw CallError("a trajectory needs at least one piece");
    if (given.breaks.size() != count + 1 || given.points.size() != past)
      throw CallError("a trajectory with " + std::to_string(count) + " degrees has " + std::to_string(count + 1) +
                      " breaks and " + std::to_string(past) + " numbers of control points, not " +
                      std::to_string(given.breaks.size()) + " and " + std::to_string(given.points.size()));
    check_finite("breaks", given.breaks), check_finite("points", given.points);
    check_durations(given.breaks);
    for (std::size_t k = 0; k < count; ++k) {
      if (k > 0 && !std::equal(given.points.begin() + static_cast<std::ptrdiff_t>(first[k] - width),
                               given.points.begin() + static_cast<std::ptrdiff_t>(first[k]),
                               given.points.begin() + static_cast<std::ptrdiff_t>(first[k])))
        throw CallError("pieces " + std::to_string(k - 1) + " and " + std::to_string(k) +
                        " do not meet: no robot can jump");
      for (const double x : std::span(given.points).subspan(first[k], (given.degrees[k] + 1) * width)) {
        if (std::fabs(x) > cell.largest_value)
          throw CallError(numbered("piece", k) + " has control points beyond " + rounded(cell.largest_value, 6));
      }
    }
  }

  void set_tube(const Trajectory& given, std::span<const double> around, const PreparedCell& cell) {
    const std::size_t width = given.error.size();
    const auto is_usable = [&](double off) { return off >= 0 && off <= cell.largest_value; };
    const bool is_row = around.size() <= 1 || around.size() == width;
    if (!is_row || !std::all_of(around.begin(), around.end(), is_usable))
      throw CallError("tube must be a number from 0 to " + rounded(cell.largest_value, 6) + ", or a row of " +
                      std::to_string(width) + ", rad and m, not " + listed(around).substr(0, kMostOfTube));
    if (!std::all_of(given.error.begin(), given.error.end(), is_usable))
      throw CallError("errors must be from 0 to " + rounded(cell.largest_value, 6) + ", rad and m, not " +
                      listed(given.error));
    for (std::size_t c = 0; c < width; ++c) {
      const double asked = around.empty() ? 0 : around[around.size() == 1 ? 0 : c];
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
  JointRows(const char* what, std::span<const double> numbers, std::size_t width) : numbers_(numbers), width_(width) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (!std::isfinite(numbers[i]))
        throw CallError(std::string(what) + " must be finite: " + numbered("point", i / width) + ", " +
                        numbered("column", i % width) + " has " + shown(numbers[i]));
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

void check_times(std::span<const double> times) {
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!std::isfinite(times[k]) || !(k == 0 ? times[k] >= 0 : times[k] > times[k - 1]))
      throw CallError("times must grow from 0 s on, but " + numbered("point", k) + " is at " + shown(times[k]) + " s");
  }
}

// `width`: of the positions; derivatives are of as many numbers, or of none.
void check_shapes(std::span<const double> times, std::span<const double> positions, std::size_t width,
                  std::span<const double> velocities, std::span<const double> accelerations) {
  const std::string count = std::to_string(times.size());
  if (width == 0 || positions.size() != times.size() * width)
    throw CallError("a trajectory takes times (n,) and positions (n, nq), not (" + count + ",) and (" +
                    std::to_string(positions.size()) + ",)");
  check_times(times);
  const auto check = [&](const char* what, std::span<const double> rows) {
    if (!rows.empty() && rows.size() != positions.size())
      throw CallError(std::string(what) + " must have the shape of positions, (" + count + ", " +
                      std::to_string(width) + "), not (" + std::to_string(rows.size()) + ",)");
  };
  check("velocities", velocities), check("accelerations", accelerations);
}

// What joint_trajectory_controller refuses, or runs in a way that nobody means.
void check_run(std::span<const double> times, std::size_t width, std::span<const double> velocities,
               std::span<const double> accelerations) {
  if (!velocities.empty()) {
    const std::span<const double> last = velocities.last(width);
    const auto fastest =
        std::max_element(last.begin(), last.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
    if (std::fabs(*fastest) > kRest)
      throw CallError("the last point has velocity " + rounded(*fastest, 3) + " in " +
                      numbered("column", static_cast<std::size_t>(fastest - last.begin())) +
                      ": jtc refuses a trajectory that does not end at rest; set the last velocities to 0");
  }
  if (velocities.empty() && !accelerations.empty() && times.size() > 1)
    throw CallError(
        "points 0 and 1 have accelerations without velocities: joint_trajectory_controller would command 0 on every "
        "joint between them; give velocities as well, or leave accelerations out");
  if (times.size() < 2)
    throw CallError("a trajectory of one point needs another one before it, where the robot comes from");
  check_durations(times);
}

}  // namespace

Result<Trajectory> Trajectory::executed(std::span<const double> times, std::span<const double> positions,
                                        std::span<const double> velocities,
                                        std::span<const double> accelerations) noexcept {
  return guarded<Trajectory>([&] {
    const std::size_t n = times.size(), width = n == 0 ? 0 : positions.size() / n;
    check_shapes(times, positions, width, velocities, accelerations);
    const JointRows q("positions", positions, width), v("velocities", velocities, width),
        a("accelerations", accelerations, width);
    check_run(times, width, velocities, accelerations);
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
      if (!impl_->cell->chained(judged.tables[k]).touching.empty()) return false;
      impl_->engine().check_motions(judged.tables[k], judged.from(trajectory, k), past - k, tolerance,
                                    state.answers.data() + k, *state.scratch);
      for (std::size_t i = k; i < past; ++i) {
        const auto answer = static_cast<MotionAnswer>(state.answers[i]);
        check_precise(answer, named_piece(trajectory, i), tolerance);
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
      const std::vector<std::int32_t>& touching = impl_->cell->chained(judged.tables[k]).touching;
      if (!touching.empty()) return MotionVerdict{false, start, -1, impl_->named(at(touching[0]))};
      const MotionReport report =
          impl_->engine().explain_motion(judged.tables[k], judged.from(trajectory, k)[0], tolerance, *state.scratch);
      check_precise(report.answer, named_piece(trajectory, k), tolerance);
      if (report.answer != MotionAnswer::kFree)
        return MotionVerdict{false, time(report.free_until), time(report.refused), impl_->named(at(report.pair))};
    }
    return MotionVerdict{true, trajectory.breaks.back(), -1, {}};
  });
}

}  // namespace plannercheck
