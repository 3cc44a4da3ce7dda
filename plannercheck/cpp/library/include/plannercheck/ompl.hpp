// plannercheck for OMPL (1.5 or later), header only: exact validity and clearance of states, and motions that are
// proved free.
//
// In: a checker whose joints are all bounded, an ompl::base::SpaceInformation of a RealVectorStateSpace. Out: its state
// validity checker, motion validator, and objective of clearance. OMPL may call all from several threads. What goes
// wrong throws ompl::Exception.
//
//   auto space = plannercheck::ompl::space_of(checker);
//   ::ompl::geometric::SimpleSetup setup(space);
//   plannercheck::ompl::allocate(*setup.getSpaceInformation(), checker);
#pragma once

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/objectives/MaximizeMinClearanceObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/util/Exception.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <plannercheck/checker.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plannercheck::ompl {

namespace base = ::ompl::base;

// A checker with workspaces for as many threads as ask at once.
class SharedChecker {
 public:
  explicit SharedChecker(Checker checker) : checker_(std::move(checker)) {}

  const Checker& checker() const { return checker_; }

  // call(checker, workspace), whose result has a value, or an exception of its error.
  template <class Call>
  auto value_of(Call call) const {
    std::unique_ptr<Workspace> workspace = taken();
    auto result = call(checker_, *workspace);
    put_back(std::move(workspace));
    if (!result.ok()) throw ::ompl::Exception("plannercheck: " + std::string(result.error()));
    return std::move(result).value();
  }

 private:
  Checker checker_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> spare_;

  std::unique_ptr<Workspace> taken() const {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return std::make_unique<Workspace>();
    std::unique_ptr<Workspace> last = std::move(spare_.back());
    spare_.pop_back();
    return last;
  }

  void put_back(std::unique_ptr<Workspace> workspace) const {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(workspace));
  }
};

inline void check_has_real_space(const base::SpaceInformation& information, const Checker& checker) {
  const auto* space = dynamic_cast<const base::RealVectorStateSpace*>(information.getStateSpace().get());
  if (space == nullptr || space->getDimension() != checker.nq()) {
    throw ::ompl::Exception("plannercheck: the state space must be a RealVectorStateSpace of " +
                            std::to_string(checker.nq()) + " numbers: take plannercheck::ompl::space_of(checker)");
  }
  if (!checker.continuous_columns().empty()) {
    throw ::ompl::Exception("plannercheck: " + checker.robot_name() +
                            " has continuous joints, which take the short way on a motion, unlike the numbers of a "
                            "RealVectorStateSpace: plan for it in Python");
  }
}

inline std::span<const double> numbers_of(const base::State* state, const Checker& checker) {
  return {state->as<base::RealVectorStateSpace::StateType>()->values, checker.nq()};
}

// The space of a checker's configurations within the joint limits, all of which have to be finite.
inline std::shared_ptr<base::RealVectorStateSpace> space_of(const Checker& checker) {
  auto space = std::make_shared<base::RealVectorStateSpace>(static_cast<unsigned int>(checker.nq()));
  base::RealVectorBounds bounds(static_cast<unsigned int>(checker.nq()));
  bounds.low.assign(checker.lower().begin(), checker.lower().end());
  bounds.high.assign(checker.upper().begin(), checker.upper().end());
  const auto is_bounded = [](double limit) { return std::isfinite(limit); };
  if (!std::all_of(bounds.low.begin(), bounds.low.end(), is_bounded) ||
      !std::all_of(bounds.high.begin(), bounds.high.end(), is_bounded))
    throw ::ompl::Exception("plannercheck: a joint of " + checker.robot_name() +
                            " has no limits: plan for it in Python");
  space->setBounds(bounds);
  return space;
}

// Whether states are free: `Checker::is_valid`. Limits are the space's.
class StateValidityChecker : public base::StateValidityChecker {
 public:
  StateValidityChecker(base::SpaceInformation* information, std::shared_ptr<const SharedChecker> checker)
      : base::StateValidityChecker(information), checker_(std::move(checker)) {
    check_has_real_space(*information, checker_->checker());
    specs_.clearanceComputationType = base::StateValidityCheckerSpecs::EXACT;
  }

  bool isValid(const base::State* state) const override {
    const std::span<const double> q = numbers_of(state, checker_->checker());
    for (const double number : q) {
      if (!std::isfinite(number)) return false;
    }
    return checker_->value_of([&](const Checker& checker, Workspace& w) { return checker.is_valid(q, w); });
  }

  // The least distance of all pairs, m, negative where bodies overlap; infinite if there are no pairs.
  double clearance(const base::State* state) const override {
    const auto nearest = checker_->value_of([&](const Checker& checker, Workspace& w) {
      return checker.distances(numbers_of(state, checker), w, std::numeric_limits<double>::infinity(), 1);
    });
    return nearest.empty() ? std::numeric_limits<double>::infinity() : nearest[0].distance;
  }

 private:
  std::shared_ptr<const SharedChecker> checker_;
};

// Whether straight motions are proved free, for every state on them.
class MotionValidator : public base::MotionValidator {
 public:
  MotionValidator(base::SpaceInformation* information, std::shared_ptr<const SharedChecker> checker,
                  double tolerance = kDefaultTolerance)
      : base::MotionValidator(information), checker_(std::move(checker)), tolerance_(tolerance) {
    check_has_real_space(*information, checker_->checker());
    checker_->value_of([&](const Checker& any, Workspace& w) { return any.check_motions({}, {}, {}, w, tolerance); });
  }

  bool checkMotion(const base::State* s1, const base::State* s2) const override {
    const bool free = checker_->value_of([&](const Checker& checker, Workspace& w) {
      return checker.check_motion(numbers_of(s1, checker), numbers_of(s2, checker), w, tolerance_);
    });
    ++(free ? valid_ : invalid_);
    return free;
  }

  // The last valid state is the one up to which the motion is proved free.
  bool checkMotion(const base::State* s1, const base::State* s2,
                   std::pair<base::State*, double>& last_valid) const override {
    const MotionVerdict verdict = checker_->value_of([&](const Checker& checker, Workspace& w) {
      return checker.explain_motion(numbers_of(s1, checker), numbers_of(s2, checker), w, tolerance_);
    });
    ++(verdict.free ? valid_ : invalid_);
    if (verdict.free) return true;
    last_valid.second = verdict.free_until;
    if (last_valid.first != nullptr) si_->getStateSpace()->interpolate(s1, s2, verdict.free_until, last_valid.first);
    return false;
  }

 private:
  std::shared_ptr<const SharedChecker> checker_;
  double tolerance_;
};

// Prefers paths whose least clearance, at the states that OMPL's resolution chooses on a motion, is largest.
inline base::OptimizationObjectivePtr clearance_objective(const base::SpaceInformationPtr& information) {
  return std::make_shared<base::MaximizeMinClearanceObjective>(information);
}

// Gives a space information its state validity checker and motion validator.
inline void allocate(base::SpaceInformation& information, const Checker& checker,
                     double tolerance = kDefaultTolerance) {
  const auto shared = std::make_shared<const SharedChecker>(checker);
  information.setStateValidityChecker(std::make_shared<StateValidityChecker>(&information, shared));
  information.setMotionValidator(std::make_shared<MotionValidator>(&information, shared, tolerance));
}

}  // namespace plannercheck::ompl
