// Loads a cell, checks the middle of the joint range, and proves the motion from there to the lower limits:
// ./check cell.plannercheck, after `plannercheck export --robot panda --scene bookshelf --output cell.plannercheck`.
#include <cstdio>
#include <plannercheck/checker.hpp>
#include <string>
#include <vector>

int main(int count, char** arguments) {
  const auto loaded = plannercheck::Checker::load(count > 1 ? arguments[1] : "cell.plannercheck");
  if (!loaded.ok()) {
    std::fprintf(stderr, "%s\n", std::string(loaded.error()).c_str());
    return 1;
  }
  const plannercheck::Checker& checker = loaded.value();
  plannercheck::Workspace workspace;  // one a thread

  std::vector<double> q0, q1(checker.lower().begin(), checker.lower().end());
  for (std::size_t k = 0; k < checker.nq(); ++k) q0.push_back(0.5 * (checker.lower()[k] + checker.upper()[k]));
  std::printf("%s in %s: the middle is %s\n", checker.robot_name().c_str(), checker.scene_name().c_str(),
              checker.is_valid(q0, workspace).value() ? "free" : "in collision");

  const plannercheck::MotionVerdict motion = checker.explain_motion(q0, q1, workspace).value();
  if (motion.free) return std::puts("the motion is proved free"), 0;
  std::printf("the motion is free up to %.6f, then %s meets %s\n", motion.free_until, motion.pair.first.c_str(),
              motion.pair.second.c_str());
  return 0;
}
