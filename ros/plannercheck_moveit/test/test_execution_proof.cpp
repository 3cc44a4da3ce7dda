// What ExecutionProof accepts and refuses, in a cell of the Panda among a bookshelf: test_execution_proof CELL.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "plannercheck_moveit/execution_proof.hpp"

using plannercheck_moveit::ExecutionProof;
using plannercheck_moveit::JointTrajectory;
using plannercheck_moveit::Judgement;

namespace {

void expect(const Judgement& judged, bool is_proved, const std::string& words) {
  if (judged.is_proved == is_proved && judged.sentence.find(words) != std::string::npos) return;
  std::fprintf(stderr, "expected %s, '%s', but got %s, '%s'\n", is_proved ? "a proof" : "no proof", words.c_str(),
               judged.is_proved ? "a proof" : "no proof", judged.sentence.c_str());
  std::exit(1);
}

// From the cell's joints, each at some value, to others in a second.
JointTrajectory between(const std::vector<std::string>& names, double from, double to) {
  const std::vector<double> zero(names.size(), 0.0);
  std::vector<double> first(names.size(), 0.0), last = first;
  first[0] = from, last[0] = to;
  first[3] = last[3] = -1.5, first[5] = last[5] = 1.5;
  return {names, {{0, first, zero, zero}, {1'000'000'000, last, zero, zero}}};
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const auto checker = plannercheck::Checker::load(arguments[1]).value();
  const std::vector<std::string>& names = checker.joint_names();
  const ExecutionProof proof(checker, 0.0);
  const JointTrajectory away = between(names, 1.5, 2.0), through = between(names, 2.0, -2.0);
  expect(proof.judge(away), true, "proved free");
  expect(proof.judge(through), false, "only: then panda_");
  expect(ExecutionProof(checker, 0.5).judge(away), false, "only: then");

  JointTrajectory turned = away;  // the same with its joints in another order
  std::swap(turned.joint_names[0], turned.joint_names[6]);
  for (auto& point : turned.points) std::swap(point.positions[0], point.positions[6]);
  expect(proof.judge(turned), true, "proved free");

  JointTrajectory other = away;
  other.joint_names[2] = "elbow";
  expect(proof.judge(other), false, "has no joint panda_joint3");
  other = away;
  other.joint_names.push_back("rail");
  expect(proof.judge(other), false, "rail, which the prepared cell holds still");
  other = away;
  other.points[1].positions.pop_back();
  expect(proof.judge(other), false, "has 6 numbers for 7 joints");
  other = away;
  other.points[1].velocities[0] = 0.5;
  expect(proof.judge(other), false, "does not end at rest");
  other = away;
  other.points[1].velocities.clear();
  expect(proof.judge(other), false, "velocities must have the shape");
  other = away;
  other.points[1].nanoseconds = 0;
  expect(proof.judge(other), false, "times must grow");
  other.points.clear();
  expect(proof.judge(other), false, "a trajectory takes times");
  return 0;
}
