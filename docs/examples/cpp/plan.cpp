// Plans with OMPL's RRTConnect from one random valid configuration to another, on motions that are proved free:
// ./plan cell.plannercheck
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>

#include <cstdio>
#include <plannercheck/ompl.hpp>
#include <string>

int main(int count, char** arguments) {
  const auto loaded = plannercheck::Checker::load(count > 1 ? arguments[1] : "cell.plannercheck");
  if (!loaded.ok()) {
    std::fprintf(stderr, "%s\n", std::string(loaded.error()).c_str());
    return 1;
  }
  const auto space = plannercheck::ompl::space_of(loaded.value());
  ompl::geometric::SimpleSetup setup(space);
  const auto& information = setup.getSpaceInformation();
  plannercheck::ompl::allocate(*information, loaded.value());
  information->setup();

  ompl::base::ScopedState<> start(space), goal(space);
  const auto sampler = information->allocValidStateSampler();
  sampler->sample(start.get());
  sampler->sample(goal.get());
  setup.setStartAndGoalStates(start, goal);
  setup.setPlanner(std::make_shared<ompl::geometric::RRTConnect>(information));
  const bool solved = static_cast<bool>(setup.solve(10.0));
  if (solved) {
    const ompl::geometric::PathGeometric& path = setup.getSolutionPath();
    std::printf("a path of %zu states, %s\n", path.getStateCount(), path.check() ? "proved free" : "not free");
  }
  return solved ? 0 : 1;
}
