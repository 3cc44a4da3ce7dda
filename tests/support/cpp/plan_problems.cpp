// Plans problems with planners of OMPL on proved motions: plan_problems PROBLEMS RANGE LIMIT ROUNDS PLANNER...
// PROBLEMS has a line for each problem: a cell's file, then the numbers of start and goal. Prints a line for each
// problem and planner: its number, the planner, the least processor time of some searches by the same seed, s, and how
// many states the path has, 0 for none. RRTConnect samples near start and goal first, as in
// plannercheck/ompl/near_first.py; RRT* ends with its first path.
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/prm/PRM.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <plannercheck/ompl.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

double processor_time() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Problem {
  plannercheck::Checker checker;
  std::vector<double> start, goal;
};

Problem problem_of(const std::string& line) {
  std::istringstream words(line);
  std::string cell;
  words >> cell;
  plannercheck::Checker checker = plannercheck::Checker::load(cell).value();
  std::vector<double> start(checker.nq()), goal(checker.nq());
  for (double& number : start) words >> number;
  for (double& number : goal) words >> number;
  return {std::move(checker), std::move(start), std::move(goal)};
}

struct Settings {
  double range, limit;
};

class Search {
 public:
  Search(const Problem& problem, const std::string& planner, const Settings& settings)
      : problem_(problem),
        space_(plannercheck::ompl::space_of(problem.checker)),
        setup_(space_),
        limit_(settings.limit),
        is_near_first_(planner == "RRTConnect") {
    const auto& information = setup_.getSpaceInformation();
    plannercheck::ompl::allocate(*information, problem.checker);
    ob::ScopedState<> start(space_), goal(space_);
    for (std::size_t k = 0; k < problem.start.size(); ++k) {
      start[static_cast<unsigned int>(k)] = problem.start[k], goal[static_cast<unsigned int>(k)] = problem.goal[k];
    }
    setup_.setStartAndGoalStates(start, goal);
    if (planner == "RRTConnect") {
      const auto made = std::make_shared<og::RRTConnect>(information);
      made->setRange(settings.range), setup_.setPlanner(made);
    } else if (planner == "RRTstar") {
      const auto made = std::make_shared<og::RRTstar>(information);
      made->setRange(settings.range), setup_.setPlanner(made);
    } else {
      setup_.setPlanner(std::make_shared<og::PRM>(information));
    }
    setup_.setup();
  }

  // Seconds, and the path's states.
  std::pair<double, std::size_t> run() {
    const double begin = processor_time();
    const auto condition =
        ob::plannerOrTerminationCondition(ob::timedPlannerTerminationCondition(limit_),
                                          ob::exactSolnPlannerTerminationCondition(setup_.getProblemDefinition()));
    if (is_near_first_) {
      near_first(condition);
    } else {
      setup_.solve(condition);
    }
    const double spent = processor_time() - begin;
    return {spent, setup_.haveExactSolutionPath() ? setup_.getSolutionPath().getStateCount() : 0};
  }

 private:
  const Problem& problem_;
  std::shared_ptr<ob::RealVectorStateSpace> space_;
  og::SimpleSetup setup_;
  double limit_;
  bool is_near_first_;

  void near_first(const ob::PlannerTerminationCondition& condition) {
    const ob::RealVectorBounds whole = space_->getBounds();
    struct Stage {
      double part;
      int iterations;
    };
    for (const Stage stage : {Stage{0.15, 1000}, Stage{0.4, 2000}}) {
      ob::RealVectorBounds box = whole;
      for (std::size_t k = 0; k < problem_.start.size(); ++k) {
        const double room = stage.part * (whole.high[k] - whole.low[k]);
        box.low[k] = std::max(whole.low[k], std::min(problem_.start[k], problem_.goal[k]) - room);
        box.high[k] = std::min(whole.high[k], std::max(problem_.start[k], problem_.goal[k]) + room);
      }
      space_->setBounds(box);
      int left = stage.iterations;
      const ob::PlannerTerminationCondition stage_ends([&left] { return left-- <= 0; });
      setup_.solve(ob::plannerOrTerminationCondition(condition, stage_ends));
      space_->setBounds(whole);
      if (condition()) return;
    }
    setup_.solve(condition);
  }
};

}  // namespace

int main(int count, char** arguments) {
  if (count < 6) return 2;
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  const Settings settings{std::stod(arguments[2]), std::stod(arguments[3])};
  const int rounds = std::stoi(arguments[4]);
  std::ifstream lines(arguments[1]);
  std::string line;
  for (int number = 0; std::getline(lines, line); ++number) {
    const Problem problem = problem_of(line);
    for (int k = 5; k < count; ++k) {
      double least = std::numeric_limits<double>::infinity();
      std::size_t states = 0;
      for (int round = 0; round < rounds; ++round) {
        ompl::RNG::setSeed(1);
        Search search(problem, arguments[k], settings);
        const auto [seconds, found] = search.run();
        least = std::min(least, seconds), states = found;
      }
      std::cout << number << ' ' << arguments[k] << ' ' << least << ' ' << states << '\n';
    }
  }
  return 0;
}
