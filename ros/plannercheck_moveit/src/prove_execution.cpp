// A response adapter of MoveIt 2: proves the trajectory that the controller will get, after all other adapters, and
// refuses or reports one that is not proved free.
#include <class_loader/class_loader.hpp>
#include <memory>
#include <moveit/planning_interface/planning_response_adapter.hpp>
#include <moveit/utils/logger.hpp>
#include <moveit_msgs/msg/robot_trajectory.hpp>
#include <optional>
#include <string>

#include "plannercheck_moveit/execution_proof.hpp"

namespace plannercheck_moveit {

class ProveExecution : public planning_interface::PlanningResponseAdapter {
 public:
  // Parameters: `cell`, a prepared cell's file; `tube`, rad and m; `refuse`, or report only.
  void initialize(const rclcpp::Node::SharedPtr& node, const std::string& parameter_namespace) override {
    const auto named = [&](const char* name) {
      return parameter_namespace.empty() ? std::string(name) : parameter_namespace + "." + name;
    };
    const auto cell = node->declare_parameter<std::string>(named("cell"), "");
    const auto tube = node->declare_parameter<double>(named("tube"), 0.0);
    refuse_ = node->declare_parameter<bool>(named("refuse"), true);
    auto loaded = plannercheck::Checker::load(cell);
    if (loaded.ok()) {
      proof_.emplace(std::move(loaded).value(), tube);
    } else {
      RCLCPP_ERROR(logger_, "no trajectory will be proved: %s", std::string(loaded.error()).c_str());
    }
  }

  [[nodiscard]] std::string getDescription() const override { return "ProveExecution"; }

  void adapt(const planning_scene::PlanningSceneConstPtr& /*scene*/,
             const planning_interface::MotionPlanRequest& /*request*/,
             planning_interface::MotionPlanResponse& response) const override {
    if (!response) return;
    const Judgement judgement = judged(response);
    if (judgement.is_proved) {
      RCLCPP_INFO(logger_, "%s", judgement.sentence.c_str());
      return;
    }
    RCLCPP_ERROR(logger_, "%s: %s", refuse_ ? "refused" : "executed nevertheless", judgement.sentence.c_str());
    if (refuse_) response.error_code = moveit::core::MoveItErrorCode::INVALID_MOTION_PLAN;
  }

 private:
  rclcpp::Logger logger_ = moveit::getLogger("plannercheck.prove_execution");
  std::optional<ExecutionProof> proof_;
  bool refuse_ = true;

  Judgement judged(const planning_interface::MotionPlanResponse& response) const {
    if (!proof_) return {false, "there is no prepared cell"};
    if (!response.trajectory) return {false, "there is no trajectory"};
    moveit_msgs::msg::RobotTrajectory message;
    response.trajectory->getRobotTrajectoryMsg(message);
    if (!message.multi_dof_joint_trajectory.joint_names.empty())
      return {false, "a joint of several numbers moves: check it in Python"};
    JointTrajectory trajectory{message.joint_trajectory.joint_names, {}};
    for (const auto& point : message.joint_trajectory.points) {
      constexpr std::int64_t kNanoseconds = 1'000'000'000;
      const std::int64_t time = point.time_from_start.sec * kNanoseconds + point.time_from_start.nanosec;
      trajectory.points.push_back({time, point.positions, point.velocities, point.accelerations});
    }
    return proof_->judge(trajectory);
  }
};

}  // namespace plannercheck_moveit

CLASS_LOADER_REGISTER_CLASS(plannercheck_moveit::ProveExecution, planning_interface::PlanningResponseAdapter)
