// Proves what joint_trajectory_controller will run of a trajectory message, in a prepared cell. Nothing here needs ROS.
//
// In: a cell, how far the robot may be off its trajectory, the points of a message. Out: whether the message may be
// executed, and a sentence that says why. What can't be judged is not accepted.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <plannercheck/checker.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plannercheck_moveit {

// A trajectory_msgs/JointTrajectory.
struct JointPoint {
  std::int64_t nanoseconds = 0;  // from the start
  std::vector<double> positions, velocities, accelerations;
};
struct JointTrajectory {
  std::vector<std::string> joint_names;
  std::vector<JointPoint> points;
};

struct Judgement {
  bool is_proved = false;
  std::string sentence;
};

class ExecutionProof {
 public:
  // `tube`: by how much each joint may be off its trajectory at every instant, rad and m; at least 0.
  ExecutionProof(plannercheck::Checker checker, double tube)
      : checker_(std::move(checker)), tube_(checker_.nq(), tube) {}

  Judgement judge(const JointTrajectory& message) const {
    const auto columns = columns_of(message);
    if (!columns.ok()) return {false, std::string(columns.error())};
    const auto trajectory = executed(message, columns.value());
    if (!trajectory.ok()) return {false, std::string(trajectory.error())};
    const std::lock_guard lock(mutex_);
    const auto verdict = checker_.explain_trajectory(trajectory.value(), workspace_, tube_);
    if (!verdict.ok()) return {false, std::string(verdict.error())};
    return described(verdict.value());
  }

 private:
  using Columns = std::vector<std::size_t>;

  plannercheck::Checker checker_;
  std::vector<double> tube_;
  mutable std::mutex mutex_;
  mutable plannercheck::Workspace workspace_;

  // The column of each of the cell's joints in the message. The cell holds all other joints where they are.
  plannercheck::Result<Columns> columns_of(const JointTrajectory& message) const {
    Columns columns;
    for (const std::string& name : checker_.joint_names()) {
      const auto found = std::find(message.joint_names.begin(), message.joint_names.end(), name);
      if (found == message.joint_names.end()) return plannercheck::Error{"the trajectory has no joint " + name};
      columns.push_back(static_cast<std::size_t>(found - message.joint_names.begin()));
    }
    for (std::size_t column = 0; column < message.joint_names.size(); ++column) {
      if (std::find(columns.begin(), columns.end(), column) == columns.end())
        return plannercheck::Error{"the trajectory has joint " + message.joint_names[column] +
                                   ", which the prepared cell holds still, or twice"};
    }
    return columns;
  }

  static plannercheck::Result<plannercheck::Trajectory> executed(const JointTrajectory& message,
                                                                 const Columns& columns) {
    std::vector<double> times, positions, velocities, accelerations;
    for (const JointPoint& point : message.points) {
      times.push_back(static_cast<double>(point.nanoseconds) / 1e9);
      for (const auto& [from, to] : {std::pair{&point.positions, &positions}, std::pair{&point.velocities, &velocities},
                                     std::pair{&point.accelerations, &accelerations}}) {
        if (!from->empty() && from->size() != message.joint_names.size())
          return plannercheck::Error{"a point of the trajectory has " + std::to_string(from->size()) + " numbers for " +
                                     std::to_string(message.joint_names.size()) + " joints"};
        for (const std::size_t column : columns) {
          if (!from->empty()) to->push_back((*from)[column]);
        }
      }
    }
    return plannercheck::Trajectory::executed(times, positions, velocities, accelerations);
  }

  Judgement described(const plannercheck::MotionVerdict& verdict) const {
    if (verdict.free) return {true, "proved free in " + checker_.scene_name()};
    std::array<char, 32> time{};
    std::snprintf(time.data(), time.size(), "%.3f s", verdict.free_until);
    return {false, "proved free up to " + std::string(time.data()) + " only: then " + verdict.pair.first + " and " +
                       verdict.pair.second + " meet, or come too near for a proof"};
  }
};

}  // namespace plannercheck_moveit
