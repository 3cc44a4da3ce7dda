"""Curves of `Trajectory` beside the controller's own code: `python tests/benchmarks/controller_curves.py FOLDER`.

FOLDER is a copy of ros2_controllers, whose trajectory.cpp is compiled with stubs of what it includes. Random messages
are linear, cubic and quintic, with points that lack derivatives, with the state before the first point, with continuous
joints, and upsampled. Printed are the largest differences of positions, velocities and accelerations, by the size of
the numbers in the message, and the largest difference of positions by the bound that the curve states
(`Curve.error`), with the curve evaluated in rationals.
"""

import argparse
import ctypes
import subprocess
import tempfile
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np

from plannercheck.trajectories import Trajectory

STUBS = {
    "angles/angles.h": """
#pragma once
#include <cmath>
namespace angles {
inline double normalize_angle(double a) {
  const double r = std::fmod(a + M_PI, 2.0 * M_PI);
  return r <= 0.0 ? r + M_PI : r - M_PI;
}
inline double shortest_angular_distance(double from, double to) { return normalize_angle(to - from); }
}""",
    "hardware_interface/macros.hpp": """
#pragma once
#define THROW_ON_NULLPTR(x) if (!x) throw 1;""",
    "rclcpp/duration.hpp": '#include "rclcpp/time.hpp"',
    "rclcpp/time.hpp": """
#pragma once
#include <cstdint>
struct Nanoseconds { int64_t ns = 0; };
namespace rclcpp {
struct Duration {
  int64_t ns;
  explicit Duration(int64_t n) : ns(n) {}
  Duration(const Nanoseconds& n) : ns(n.ns) {}
  static Duration from_seconds(double s) { return Duration(static_cast<int64_t>(s * 1e9)); }
  double seconds() const { return static_cast<double>(ns) / 1e9; }
};
struct Time {
  int64_t ns;
  Time(int64_t n = 0) : ns(n) {}
  Time(const Nanoseconds& n) : ns(n.ns) {}
  double seconds() const { return static_cast<double>(ns) / 1e9; }
  Duration operator-(const Time& o) const { return Duration(ns - o.ns); }
  Time operator+(const Duration& d) const { return Time(ns + d.ns); }
  auto operator<=>(const Time&) const = default;
};
}""",
    "joint_trajectory_controller/interpolation_methods.hpp": """
#pragma once
namespace joint_trajectory_controller::interpolation_methods {
enum class InterpolationMethod { NONE, VARIABLE_DEGREE_SPLINE };
}""",
    "trajectory_msgs/msg/joint_trajectory_point.hpp": """
#pragma once
#include <vector>
#include "rclcpp/time.hpp"
namespace trajectory_msgs::msg {
struct JointTrajectoryPoint {
  std::vector<double> positions, velocities, accelerations, effort;
  Nanoseconds time_from_start;
};
}""",
    "trajectory_msgs/msg/joint_trajectory.hpp": """
#pragma once
#include <algorithm>
#include <memory>
#include <string>
#include "trajectory_msgs/msg/joint_trajectory_point.hpp"
namespace trajectory_msgs::msg {
struct JointTrajectory {
  struct { Nanoseconds stamp; } header;
  std::vector<std::string> joint_names;
  std::vector<JointTrajectoryPoint> points;
};
}""",
    "face.cpp": """
#include <cmath>
#include "joint_trajectory_controller/trajectory.hpp"
using namespace joint_trajectory_controller;
using Point = trajectory_msgs::msg::JointTrajectoryPoint;
// Rows: time in ns, flags (1 velocities, 2 accelerations), then positions, velocities, accelerations.
static Point point(const double* row, int nq) {
  Point p;
  p.time_from_start.ns = static_cast<int64_t>(row[0]);
  const int flags = static_cast<int>(row[1]);
  p.positions.assign(row + 2, row + 2 + nq);
  if (flags & 1) p.velocities.assign(row + 2 + nq, row + 2 + 2 * nq);
  if (flags & 2) p.accelerations.assign(row + 2 + 2 * nq, row + 2 + 3 * nq);
  return p;
}
extern "C" void run(int n, int nq, const double* rows, const double* before, const int* continuous, int upsample,
                    int samples, const double* times, double* out) {
  auto message = std::make_shared<trajectory_msgs::msg::JointTrajectory>();
  for (int k = 0; k < n; ++k) message->points.push_back(point(rows + k * (2 + 3 * nq), nq));
  if (upsample) fill_cubic_spline_velocities(*message);
  const int64_t now = 1000000000;
  message->header.stamp.ns = now;
  Trajectory trajectory(message);
  trajectory.set_point_before_trajectory_msg(rclcpp::Time(now), point(before, nq),
                                             std::vector<bool>(continuous, continuous + nq));
  for (int k = 0; k < samples; ++k) {
    Point state;
    TrajectoryPointConstIter a, b;
    trajectory.sample(rclcpp::Time(now + static_cast<int64_t>(times[k])),
                      interpolation_methods::InterpolationMethod::VARIABLE_DEGREE_SPLINE, state, a, b);
    for (int j = 0; j < nq; ++j) {
      out[(k * 3 + 0) * nq + j] = state.positions[j];
      out[(k * 3 + 1) * nq + j] = state.velocities[j];
      out[(k * 3 + 2) * nq + j] = state.accelerations[j];
    }
  }
}""",
}


def compiled(folder: Path, into: Path) -> ctypes.CDLL:
    """The controller's code with stubs, as a library."""
    source = folder / "joint_trajectory_controller"
    for name, text in STUBS.items():
        (into / name).parent.mkdir(parents=True, exist_ok=True)
        (into / name).write_text(text)
    files = [str(into / "face.cpp"), str(source / "src/trajectory.cpp")]
    include = [f"-I{into}", f"-I{source / 'include'}"]
    library = into / "controller.so"
    subprocess.run(["g++", "-std=c++20", "-O1", "-shared", "-fPIC", *include, *files, "-o", library], check=True)
    return ctypes.CDLL(str(library))


def differences(library: ctypes.CDLL, rng: np.random.Generator) -> np.ndarray:
    """(4,) the largest differences of a random message, by the size of its numbers; positions by the stated bound."""
    n, nq, samples = int(rng.integers(2, 8)), int(rng.integers(1, 4)), 20
    steps = rng.integers(10**6, 3 * 10**9, n) if rng.random() < 0.7 else rng.integers(10**6, 10**7, n)
    ns = np.cumsum(steps)
    upsample = bool(rng.random() < 0.2)
    kinds = np.full(n, 0 if upsample else rng.choice([0, 1, 3]))
    if not upsample and rng.random() < 0.3:
        kinds = rng.choice([0, 1, 3], n)
    q, v, a = rng.normal(size=(3, n, nq)) * [[[2.0]], [[1.0]], [[3.0]]]
    v[-1] = 0
    table = np.column_stack([ns, kinds, q, v, a]).astype(np.float64)
    start, speed = rng.normal(size=(2, nq)) * 4
    moving = bool(rng.random() < 0.5)
    before = np.concatenate([[0, 1 if moving else 0], start, speed, np.zeros(nq)])
    continuous = rng.integers(0, 2, nq).astype(np.int32)
    times = np.sort(rng.integers(0, ns[-1], samples)).astype(np.float64)
    out = np.zeros((samples, 3, nq))
    pointer = lambda x: x.ctypes.data_as(ctypes.c_void_p)  # noqa: E731
    library.run(
        n,
        nq,
        pointer(table),
        pointer(before),
        pointer(continuous),
        int(upsample),
        samples,
        pointer(times),
        pointer(out),
    )
    made = Trajectory(
        ns / 1e9,
        q,
        np.where(kinds[:, None] & 1, v, np.nan),
        np.where(kinds[:, None] & 2, a, np.nan),
        "jtc-upsampled" if upsample else "jtc",
        (start, speed) if moving else start,
        np.flatnonzero(continuous).tolist(),
    )
    shortest = float(np.diff(made.curve.breaks).min())
    found = np.stack([made.position(times / 1e9), made.velocity(times / 1e9), made.acceleration(times / 1e9)], axis=1)
    size = max(np.abs(control).max() for control in made.curve.pieces)
    by_size = np.abs(found - out).max(axis=(0, 2)) * [1, shortest, shortest**2] / size
    return np.append(by_size, by_bound(made, times[:: samples // 3], out[:: samples // 3, 0]))


def by_bound(made: Trajectory, times: np.ndarray, positions: np.ndarray) -> float:
    """The largest difference of positions from the curve's rational values, by the stated bound."""
    worst = 0.0
    stamps = np.rint(made.curve.breaks * 1e9).astype(np.int64)
    for time, row in zip(times.astype(np.int64).tolist(), positions.tolist(), strict=True):
        k = int(np.searchsorted(stamps[1:-1], time, side="right"))
        s = Fraction(time - int(stamps[k]), int(stamps[k + 1] - stamps[k]))
        for j, position in enumerate(row):
            points = [Fraction(x) for x in made.curve.pieces[k][:, j].tolist()]
            while len(points) > 1:
                points = [a + (b - a) * s for a, b in pairwise(points)]
            difference, bound = abs(points[0] - Fraction(position)), Fraction(float(made.curve.error[j]))
            worst = max(worst, float(difference / bound) if bound else float(difference > 0) * np.inf)
    return worst


def main() -> None:
    """Compares random messages."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as into:
        library = compiled(options.folder, Path(into))
        rng = np.random.default_rng(options.seed)
        worst = np.max([differences(library, rng) for _ in range(options.count)], axis=0)
    for name, value in zip(("positions", "velocities", "accelerations"), worst[:3], strict=True):
        print(f"{name}: {value:.2e} of the size of the numbers")
    print(f"positions: {worst[3]:.3f} of the stated bound")


if __name__ == "__main__":
    main()
