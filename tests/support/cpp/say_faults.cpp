// Says the sentence of each fault of tests/support/cell_faults.py, as name, tab, sentence: `say_faults CELL LIFT
// STAND_INS`, prepared cells of the checkers there.
#include <array>
#include <cstdio>
#include <limits>
#include <plannercheck/checker.hpp>
#include <span>
#include <string>
#include <vector>

namespace {

using plannercheck::Checker;
using plannercheck::Trajectory;
using Row = std::vector<double>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

plannercheck::Workspace workspace;

template <class T>
void say(const char* name, const plannercheck::Result<T>& result) {
  std::printf("%s\t%s\n", name, result.ok() ? "no fault" : std::string(result.error()).c_str());
}

Row with(Row row, std::size_t at, double value) {
  row[at] = value;
  return row;
}

std::array<double, 16> with(std::array<double, 16> pose, std::size_t at, double value) {
  pose[at] = value;
  return pose;
}

const Row kZeros(7), kTwo(14);
constexpr std::array<double, 16> kHere{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr std::array<double, 3> kCube{1, 1, 1}, kOrigin{0, 0, 0};

void configurations(const Checker& checker) {
  std::vector<std::uint8_t> two(2);
  const Row few(5), wrong = with(kZeros, 3, kNan), far{-0.1, 1e-7, 2e15, 0, 1e22, 0.1 + 0.2, 123456.789};
  const Row second = [&] {
    Row rows = kZeros;
    rows.insert(rows.end(), far.begin(), far.end());
    return rows;
  }();
  say("too few numbers", checker.is_valid(few, workspace));
  say("too many numbers in a set", checker.check_states(Row(15), two, workspace));
  say("too few numbers at a motion's end", checker.check_motion(kZeros, few, workspace));
  say("too few numbers to explain", checker.explain(few, workspace));
  say("too few numbers to measure", checker.distances(few, workspace));
  say("a number that is none", checker.is_valid(wrong, workspace));
  say("a number that is none, to explain", checker.explain(wrong, workspace));
  say("a number that is none at a motion's end", checker.check_motion(kZeros, wrong, workspace));
  say("an infinite number", checker.is_valid(with(kZeros, 0, -kInf), workspace));
  say("a number beyond all joints", checker.check_states(second, two, workspace));
  say("a number beyond all joints, to measure", checker.distances(far, workspace));
  for (const double tolerance : {0.0, -1e-4, kNan, kInf, -123456.7891})
    say("a tolerance", checker.check_motion(kZeros, kZeros, workspace, tolerance));
  say("a tolerance below rounding", checker.check_motion(kZeros, with(kZeros, 0, 1e-3), workspace, 1e-17));
  for (const double limit : {0.0, -0.1, kNan}) say("a limit", checker.distances(kZeros, workspace, limit));
}

void obstacles(const Checker& checker) {
  say("no name", checker.with_box("", kCube, kHere));
  say("a link's name", checker.with_box("panda_hand", kCube, kHere));
  say("a name that is not there, to move", checker.with_pose("cratr", kHere));
  say("a name that is not there, after edits",
      checker.without("rack").value().with_box("rack", kCube, kHere).value().with_pose("rick", kHere));
  say("a name that is not there, to remove", checker.without("rick"));
  say("no name to remove", checker.without(""));
  for (const double edge : {-1.0, kNan, kInf})
    say("an edge", checker.with_box("new", std::array{1.0, edge, 1.0}, kHere));
  say("a large edge", checker.with_box("new", std::array{1.0, 3e50, 1.0}, kHere));
  for (const double radius : {-1.0, kNan, kInf, 1e51}) say("a radius", checker.with_sphere("new", radius, kOrigin));
  say("a centre", checker.with_sphere("new", 1, std::array{0.0, kNan, 0.0}));
  for (const double radius : {0.0, -1.0, kNan, 1e51})
    say("a cloud's radius", checker.with_cloud("new", Row(3), radius, kHere));
  Row points{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  say("points of a hull in no rows", checker.with_hull("new", Row(13), kHere));
  say("points of a cloud in no rows", checker.with_cloud("new", Row(4), 0.1, kHere));
  for (const std::size_t count : {0u, 1u, 3u})
    say("few points of a hull", checker.with_hull("new", std::span(points).first(3 * count), kHere));
  say("few points of a hull, and wrong ones", checker.with_hull("new", Row{0, 0, 0, 1, kNan, 0, 0, 1, 0}, kHere));
  say("a point of a hull", checker.with_hull("new", with(points, 4, kNan), kHere));
  say("a point of a cloud", checker.with_cloud("new", with(points, 4, kNan), 0.1, kHere));
  say("a large point of a hull", checker.with_hull("new", with(points, 4, 2e50), kHere));
  say("a huge point of a hull", checker.with_hull("new", with(points, 4, 1e200), kHere));
  say("a point of a cloud without a radius", checker.with_cloud("new", with(points, 4, kNan), 0, kHere));
  say("a large point of a cloud", checker.with_cloud("new", with(points, 4, -2e50), 0.1, kHere));
  say("a stretched pose", checker.with_box("new", kCube, with(kHere, 0, 1.1)));
  say("a mirrored pose", checker.with_box("new", kCube, with(kHere, 0, -1)));
  say("a pose that is hardly stretched", checker.with_box("new", kCube, with(kHere, 10, 1.00001)));
  say("a mirrored pose far away", checker.with_box("new", kCube, with(with(with(kHere, 3, 1e60), 7, -1e300), 10, -1)));
  say("a pose beyond all doubles",
      checker.with_box("new", kCube, with(with(with(with(kHere, 0, 1e200), 1, 1e200), 4, 1e200), 5, -1e200)));
  say("a pose's last row that is none", checker.with_box("new", kCube, with(with(kHere, 12, kNan), 0, 2)));
  say("a stretched pose's last row", checker.with_box("new", kCube, with(with(kHere, 15, 2), 0, 2)));
  say("a link's name at no pose", checker.with_box("panda_hand", kCube, with(kHere, 0, 2)));
  say("a part's name", checker.with_box("rack/0", kCube, kHere));
  say("a pose's last row", checker.with_box("new", kCube, with(kHere, 12, 1)));
  say("a pose that is none", checker.with_pose("crate", with(kHere, 7, kNan)));
  say("a stretched pose to move to", checker.with_pose("crate", with(kHere, 5, 0.9)));
}

void trajectories(const Checker& checker) {
  const Row times{0, 1};
  const Row wrong = with(kTwo, 9, kNan), moving = with(with(kTwo, 10, 0.5), 8, -0.25);
  say("no points", Trajectory::executed({}, {}));
  say("one point", Trajectory::executed(Row{0}, kZeros));
  say("positions in no rows", Trajectory::executed(times, Row(15)));
  say("velocities in no rows", Trajectory::executed(times, kTwo, Row(15)));
  say("times that fall", Trajectory::executed(Row{0, 2, 1}, Row(21)));
  say("times before 0", Trajectory::executed(Row{-1, 2}, kTwo));
  say("times that are none", Trajectory::executed(Row{0, kNan}, kTwo));
  say("times too close", Trajectory::executed(Row{0, 1e-10}, kTwo));
  say("a position that is none", Trajectory::executed(times, wrong));
  say("a velocity that is none", Trajectory::executed(times, kTwo, wrong));
  say("an acceleration that is none", Trajectory::executed(times, kTwo, kTwo, wrong));
  say("accelerations alone", Trajectory::executed(times, kTwo, {}, kTwo));
  say("an end that moves", Trajectory::executed(times, kTwo, moving));
  const Trajectory still = Trajectory::executed(times, kTwo).value();
  say("a tube below 0", checker.check_trajectory(still, workspace, with(kZeros, 2, -1)));
  say("a tube of one number below 0", checker.check_trajectory(still, workspace, Row{-1}));
  say("a tube of three", checker.check_trajectory(still, workspace, Row(3)));
  say("a tube that is none", checker.check_trajectory(still, workspace, Row(7, kNan)));
  say("a trajectory's tolerance", checker.check_trajectory(still, workspace, {}, -1));
  say("a trajectory's tolerance below rounding", checker.check_trajectory(still, workspace, {}, 1e-18));
  say("a trajectory of another robot",
      checker.check_trajectory(Trajectory::executed(times, Row(10)).value(), workspace));
  const Trajectory far = Trajectory::executed(times, with(kTwo, 8, 1e16)).value();
  say("a trajectory beyond all joints", checker.check_trajectory(far, workspace));
  Trajectory curve{{0, 1, 2}, {1, 1}, Row(28), kZeros};
  curve.points[14] = 1;
  say("pieces that do not meet", checker.check_trajectory(curve, workspace));
  curve = {{0, 1}, {24}, Row(25 * 7), kZeros};
  say("a piece of a high degree", checker.check_trajectory(curve, workspace));
  curve = {{0, 1e-10}, {1}, kTwo, kZeros};
  say("a short piece", checker.check_trajectory(curve, workspace));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) return 2;
  const Checker checker = Checker::load(arguments[1]).value(), lift = Checker::load(arguments[2]).value();
  configurations(checker), obstacles(checker), trajectories(checker);
  Row turned = lift.nq() == 15 ? Row{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1.25} : Row();
  say("a quaternion of another length", lift.is_valid(turned, workspace));
  say("a cosine and sine of another length", lift.is_valid(with(with(turned, 14, 1), 7, 0.5), workspace));
  say("too few numbers of several joints", lift.is_valid(Row(3), workspace));
  const Checker stand_ins = Checker::load(arguments[3]).value();
  say("a mirrored pose for stand-ins", stand_ins.with_box("new", kCube, with(kHere, 0, -1)));
  say("stand-ins in another scene", stand_ins.with_box("new", kCube, kHere));
}
