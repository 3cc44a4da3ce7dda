// plannercheck for C++: exact collision verdicts and proved motions of one robot in one scene.
//
// In: a prepared cell, which Python or the command line writes (`checker.save`, `plannercheck export`); configurations
// and motions as plain doubles. Out: the same verdicts as in Python, bit for bit. Nothing here throws: what can fail
// returns a Result, whose error is a sentence that names the input and the remedy.
//
//   plannercheck::Checker checker = plannercheck::Checker::load("cell.plannercheck").value();
//   plannercheck::Workspace workspace;  // one a thread
//   bool free = checker.is_valid(q, workspace).value();
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#if defined(__GNUC__)
#define PLANNERCHECK_API __attribute__((visibility("default")))
#define PLANNERCHECK_HIDDEN __attribute__((visibility("hidden")))
#else
#define PLANNERCHECK_API
#define PLANNERCHECK_HIDDEN
#endif

namespace plannercheck {

struct Error {
  std::string message;
};

// Ends the program with the message on the error stream.
[[noreturn]] PLANNERCHECK_API void end_without_value(const Error& error) noexcept;

// A value, or why there is none. It does not convert to bool, since that would look like a verdict.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) noexcept : outcome_(std::move(value)) {}
  Result(Error error) noexcept : outcome_(std::move(error)) {}

  bool ok() const noexcept { return outcome_.index() == 0; }
  // Ends the program if there is none.
  const T& value() const& noexcept {
    end_unless_ok();
    return *std::get_if<0>(&outcome_);
  }
  T value() && noexcept {
    end_unless_ok();
    return std::move(*std::get_if<0>(&outcome_));
  }
  // Empty if there is none.
  std::string_view error() const noexcept {
    return ok() ? std::string_view() : std::string_view(std::get_if<1>(&outcome_)->message);
  }

 private:
  std::variant<T, Error> outcome_;

  void end_unless_ok() const noexcept {
    if (!ok()) end_without_value(*std::get_if<1>(&outcome_));
  }
};

// The link, and the other link or the obstacle, of a pair of bodies.
struct NamedPair {
  std::string first, second;
};

struct Collision : NamedPair {
  std::array<double, 3> point{};  // a common point of both bodies, in the world, m: computed exactly, then rounded
};

// A pair that is apart, paddings included, and the plane halfway between its bodies. The numbers are rounded; exact
// arithmetic has proved that the exact plane separates the bodies.
struct Separation : NamedPair {
  bool has_plane = false;          // false of solids and sets of parts whose hulls, or the boxes around them, meet
  std::array<double, 3> normal{};  // of length 1, in the world, from the second to the first
  double offset = 0;               // m: normal · x is more on the first, less on the second
  double gap = 0;                  // a lower bound of the distance between them, m
};

// All pairs that collide at one configuration and, if asked for, all others.
struct Verdict {
  bool valid = true;
  std::vector<Collision> collisions;
  std::vector<Separation> separations;
};

// How far a motion or trajectory is proved free: `free_until` is a motion's parameter, from 0 to 1, or a trajectory's
// time, s. If it is not free, `pair` comes within the tolerance at `near_at` (−1 if no state was found: bodies that
// never move relative to each other touch); of several such pairs, Python may name another.
struct MotionVerdict {
  bool free = true;
  double free_until = 1, near_at = -1;
  NamedPair pair;
};

// A pair that is near at a configuration, without the padding.
struct Distance {
  std::size_t state = 0;  // which configuration
  NamedPair pair;
  double distance = 0;  // m; negative if the bodies overlap: moving the first so far along the normal separates them
  double lower = 0;     // a proved lower bound, m: of two hulls that are apart, along the normal
  std::array<double, 3> on_first{}, on_second{};  // nearest points in the world, m
  std::array<double, 3> normal{};                 // of length 1, in the world, from the second to the first
  double gap = 0;       // all nearest pairs of points are this near to the given one, m; infinite if not proved
  bool unique = false;  // whether there is one such pair, so that the distance has the gradient
  std::vector<double> gradient;  // by the configuration, a number for each of Pinocchio's tangent, m/rad and m/m
};

// A trajectory: polynomials in time, one after the other.
struct Trajectory {
  std::vector<double> breaks;        // (m + 1) s, growing
  std::vector<std::size_t> degrees;  // (m) from 1 to 20
  std::vector<double> points;  // the Bernstein coefficients of each, degree + 1 rows of nq numbers; all pieces meet
  std::vector<double> error;   // (nq) how far these are at most from the polynomials that are meant; zeros if exact

  // What joint_trajectory_controller runs between points: times (n) s, positions (n · nq), then velocities, and
  // accelerations beside velocities, of all points or of none.
  PLANNERCHECK_API static Result<Trajectory> executed(std::span<const double> times, std::span<const double> positions,
                                                      std::span<const double> velocities = {},
                                                      std::span<const double> accelerations = {}) noexcept;
};

// The scratch memory of one thread, for any checkers. It also keeps statistics of earlier calls; no verdict depends on
// them.
class PLANNERCHECK_API Workspace {
 public:
  Workspace() noexcept;
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

 private:
  friend class Checker;
  struct PLANNERCHECK_HIDDEN State;
  std::unique_ptr<State> state_;
};

// A motion that keeps more than this from all collisions is proved free, m; one that comes nearer may be refused.
inline constexpr double kDefaultTolerance = 1e-4;

// Verdicts of one robot in one scene. Immutable, and cheap to copy; threads may share it.
class PLANNERCHECK_API Checker {
 public:
  // Reads a file that Python's Checker.save or `plannercheck export` wrote. A damaged, cut, hostile or other version's
  // file is an error.
  static Result<Checker> load(const std::string& path) noexcept;
  // Reads the bytes of such a file.
  static Result<Checker> parse(std::span<const std::byte> file) noexcept;

  Checker(const Checker&) noexcept;
  Checker(Checker&&) noexcept;
  Checker& operator=(const Checker&) noexcept;
  Checker& operator=(Checker&&) noexcept;
  ~Checker();

  // How many numbers a configuration has: rad and m, in the order of Python's robot.joint_names.
  std::size_t nq() const noexcept;
  // (nq) the joint limits, which may be infinite. They are no part of a verdict.
  std::span<const double> lower() const noexcept;
  std::span<const double> upper() const noexcept;
  // The columns of continuous joints, which take the short way on a motion.
  std::span<const std::size_t> continuous_columns() const noexcept;
  const std::string& robot_name() const noexcept;
  const std::string& scene_name() const noexcept;
  const std::vector<std::string>& joint_names() const noexcept;
  const std::vector<std::string>& link_names() const noexcept;
  // What wrote the file, and the versions it had.
  const std::string& about() const noexcept;
  // The instruction set that is used: "v2", "v3", "v4" or "plain". PLANNERCHECK_LEVEL in the environment chooses
  // another one when a checker is loaded; verdicts are the same.
  std::string_view level() const noexcept;

  // Whether no pair of bodies shares a point at the configuration q (nq). Touching is a collision.
  Result<bool> is_valid(std::span<const double> q, Workspace& workspace) const noexcept;
  // is_valid for n configurations, q (n · nq), one after the other: valid[i] is 1 or 0. Returns how many are valid.
  Result<std::size_t> check_states(std::span<const double> q, std::span<std::uint8_t> valid,
                                   Workspace& workspace) const noexcept;
  // Whether the motion from q0 to q1 (nq each) is proved free for every state on it, both ends included. Joints move
  // linearly, continuous ones the short way round, quaternions by slerp, floating bases along one screw. A motion that
  // leaves the limits (of floating and planar bases: ±1 m) by more than 10 rad or m is an error.
  // `tolerance`: more than 0, m.
  Result<bool> check_motion(std::span<const double> q0, std::span<const double> q1, Workspace& workspace,
                            double tolerance = kDefaultTolerance) const noexcept;
  // check_motion for n motions: free[i] is 1 or 0. Returns how many are free.
  Result<std::size_t> check_motions(std::span<const double> q0, std::span<const double> q1,
                                    std::span<std::uint8_t> free, Workspace& workspace,
                                    double tolerance = kDefaultTolerance) const noexcept;
  // Whether a trajectory is proved free at every instant, for joints of one number each. `tube`: (nq) by how much each
  // number may be off at every instant, all at once, or one for all; none if empty.
  Result<bool> check_trajectory(const Trajectory& trajectory, Workspace& workspace, std::span<const double> tube = {},
                                double tolerance = kDefaultTolerance) const noexcept;
  // All pairs that collide at q, by name, each with a common point; `separations`: also all other pairs, with planes.
  Result<Verdict> explain(std::span<const double> q, Workspace& workspace, bool separations = false) const noexcept;
  // How far a motion is free, and what stops it.
  Result<MotionVerdict> explain_motion(std::span<const double> q0, std::span<const double> q1, Workspace& workspace,
                                       double tolerance = kDefaultTolerance) const noexcept;
  Result<MotionVerdict> explain_trajectory(const Trajectory& trajectory, Workspace& workspace,
                                           std::span<const double> tube = {},
                                           double tolerance = kDefaultTolerance) const noexcept;
  // The pairs nearer than the limit, m, at each of some configurations; or, if `nearest` is not 0, that many nearest
  // pairs of each. Rows are in the order of the configurations, the nearest pair first. Each new limit, which may be
  // infinite, is prepared once.
  Result<std::vector<Distance>> distances(std::span<const double> q, Workspace& workspace, double limit = 0.1,
                                          std::size_t nearest = 0) const noexcept;

  // The same checker in another scene: with an obstacle that is added or, if it has that name, replaces one. Paddings
  // and allowed collisions of its name act as in Python's with_scene. A pose is a matrix (4, 4), row by row, m.
  using Pose = std::span<const double, 16>;
  // A box by its edge lengths (3), m.
  Result<Checker> with_box(const std::string& name, std::span<const double, 3> size, Pose pose) const noexcept;
  // A ball about a point (3), m.
  Result<Checker> with_sphere(const std::string& name, double radius, std::span<const double, 3> centre) const noexcept;
  // The convex hull of points (n · 3), m.
  Result<Checker> with_hull(const std::string& name, std::span<const double> points, Pose pose) const noexcept;
  // All points within a radius of the points of a cloud (n · 3), m.
  Result<Checker> with_cloud(const std::string& name, std::span<const double> points, double radius,
                             Pose pose) const noexcept;
  // With an obstacle's frame at another pose, as Scene.move places it in Python; and without an obstacle.
  Result<Checker> with_pose(const std::string& name, Pose pose) const noexcept;
  Result<Checker> without(const std::string& name) const noexcept;

 private:
  struct PLANNERCHECK_HIDDEN Impl;
  explicit Checker(std::shared_ptr<const Impl> impl) noexcept;
  std::shared_ptr<const Impl> impl_;

  PLANNERCHECK_HIDDEN Workspace::State& state_of(Workspace& workspace) const;
};

}  // namespace plannercheck
