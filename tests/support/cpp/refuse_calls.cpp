// Faults that Python can't be given, or for which it knows another remedy: `refuse_calls CELL FOLDER`, a Panda's cell
// in which the hand carries "tool". The exit code is 1, and the sentence is said, where another one is expected.
#include <sys/stat.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <plannercheck/checker.hpp>
#include <string>
#include <vector>

namespace {

using plannercheck::Checker;
using plannercheck::Trajectory;
using Row = std::vector<double>;

int wrong = 0;

template <class T>
void expect(const std::string& sentence, const plannercheck::Result<T>& result) {
  if (!result.ok() && result.error() == sentence) return;
  ++wrong;
  std::printf("expected: %s\n     got: %s\n", sentence.c_str(),
              result.ok() ? "no fault" : std::string(result.error()).c_str());
}

void files(const std::filesystem::path& folder) {
  const std::string large = folder / "large", pipe = folder / "pipe", loop = folder / "loop";
  std::ofstream(large) << "no cell";
  std::filesystem::resize_file(large, std::uintmax_t{1} << 40);  // more than the memory
  expect(large + " is no prepared cell: it does not start with 'plannercheck'", Checker::load(large));
  std::filesystem::remove(large);
  if (mkfifo(pipe.c_str(), 0600) == 0)
    expect("can't read a cell from " + pipe + ": it is a pipe or a device", Checker::load(pipe));
  std::filesystem::create_symlink("loop", loop);
  expect("can't read a cell from " + loop + ": Too many levels of symbolic links", Checker::load(loop));
  expect("can't read a cell from " + loop + "/x: Too many levels of symbolic links", Checker::load(loop + "/x"));
}

void sizes(const Checker& checker) {
  plannercheck::Workspace workspace;
  const Row two(14);
  std::vector<std::uint8_t> none, one(1);
  expect("14 numbers are 2 configurations, not 0: one for each answer", checker.check_states(two, none, workspace));
  expect("14 numbers are 2 configurations, not 1: one for each answer", checker.check_states(two, one, workspace));
  expect("14 numbers are 2 configurations, not 1: one for each answer", checker.check_motion(two, two, workspace));
}

void carried(const Checker& checker) {
  const std::array<double, 16> here{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const std::string sentence = "object 'tool' is attached to a link: change it in Python, and save the cell again";
  expect(sentence, checker.with_box("tool", std::array{1.0, 1.0, 1.0}, here));
  expect(sentence, checker.with_pose("tool", here));
  expect(sentence, checker.without("tool"));
}

void trajectories(const Checker& checker) {
  plannercheck::Workspace workspace;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const Row still(14), zeros(7);
  const auto refused = [&](const std::string& sentence, const Trajectory& trajectory) {
    expect(sentence, checker.check_trajectory(trajectory, workspace));
    expect(sentence, checker.explain_trajectory(trajectory, workspace));
  };
  refused("the trajectory has no errors: give 7 numbers, zeros where its control points are exact",
          {{0, 1}, {1}, still, {}});
  refused("a trajectory needs at least one piece", {{0}, {}, {}, zeros});
  refused("a trajectory with 1 degrees has 2 breaks and 14 numbers of control points, not 1 and 7",
          {{0}, {1}, zeros, zeros});
  refused("breaks must be finite: number 1 is inf", {{0, kInf}, {1}, still, zeros});
  refused("breaks must be finite: number 0 is -inf", {{-kInf, 0}, {1}, still, zeros});
  Row points = still;
  points[9] = -kInf;
  refused("points must be finite: number 9 is -inf", {{0, 1}, {1}, points, zeros});
  points[9] = 1e40;  // of an error that is beyond all joints as well
  refused("piece 0 has control points beyond 1e+15", Trajectory::executed(Row{0, 1}, points).value());
  refused("errors must be from 0 to 1e+15, rad and m, not [1e+16, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
          {{0, 1}, {1}, still, {1e16, 0, 0, 0, 0, 0, 0}});
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  const Checker checker = Checker::load(arguments[1]).value();
  files(arguments[2]), sizes(checker), carried(checker), trajectories(checker);
  return wrong == 0 ? 0 : 1;
}
