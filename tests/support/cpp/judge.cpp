// Judges configurations and motions of a prepared cell, for comparison with Python: judge CELL STATES STARTS ENDS OUT.
// Inputs are files of doubles. OUT gets a byte for each state and one for each motion; then the same of the first
// kEdited ones after each of some edits of the scene; then common points of what collides in the cell; then of the
// cell, and with the first edit, trajectories and distances. Prints processor times.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <plannercheck/checker.hpp>
#include <span>
#include <string>
#include <vector>

namespace {

using plannercheck::Checker;

constexpr std::size_t kEdited = 2000, kMeasured = 500, kExplained = 200, kSeparated = 10;

std::vector<double> doubles(const char* path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<double> out(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size() * sizeof(double)));
  return out;
}

double seconds(std::clock_t begin) { return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC; }

struct Inputs {
  std::vector<double> states, starts, ends;
};

// Appends the verdicts of at most so many states and motions.
void judge(const Checker& checker, const Inputs& given, std::size_t most, std::vector<std::uint8_t>& out, bool told) {
  const std::size_t nq = checker.nq();
  std::vector<std::uint8_t> valid(std::min(most, given.states.size() / nq)),
      free(std::min(most, given.starts.size() / nq));
  plannercheck::Workspace workspace;
  const std::span<const double> states(given.states), starts(given.starts), ends(given.ends);
  std::clock_t begin = std::clock();
  const std::size_t are_valid = checker.check_states(states.first(valid.size() * nq), valid, workspace).value();
  const double of_states = seconds(begin);
  begin = std::clock();
  const std::size_t are_free =
      checker.check_motions(starts.first(free.size() * nq), ends.first(free.size() * nq), free, workspace).value();
  const double of_motions = seconds(begin);
  if (told) {
    std::printf("%zu of %zu states valid, %.3f us each\n%zu of %zu motions free, %.3f us each\n", are_valid,
                valid.size(), 1e6 * of_states / static_cast<double>(valid.size()), are_free, free.size(),
                1e6 * of_motions / static_cast<double>(free.size()));
  }
  out.insert(out.end(), valid.begin(), valid.end());
  out.insert(out.end(), free.begin(), free.end());
}

// The same edits as in tests/benchmarks/cpp_library.py: a ball, a crate that then moves, a cloud, a smaller crate.
std::vector<Checker> edited(const Checker& checker) {
  const std::array<double, 16> here{1, 0, 0, 0.5, 0, 1, 0, 0.25, 0, 0, 1, 0.5, 0, 0, 0, 1};
  const std::array<double, 16> there{0, -1, 0, -0.25, 1, 0, 0, 0.5, 0, 0, 1, 0.75, 0, 0, 0, 1};
  const std::array<double, 3> size{0.25, 0.5, 0.125}, small{0.125, 0.125, 0.125}, centre{0.25, -0.5, 0.625};
  std::vector<double> cloud;
  for (int i = 0; i < 16; ++i) {
    for (int j = 0; j < 16; ++j) cloud.insert(cloud.end(), {0.0625 * i, 0.0625 * j, 0.03125 * (i ^ j)});
  }
  std::vector<Checker> out{checker.with_sphere("new ball", 0.125, centre).value()};
  out.push_back(out.back().with_box("new crate", size, here).value());
  out.push_back(out.back().with_pose("new crate", there).value());
  out.push_back(out.back().with_cloud("new cloud", cloud, 0.03125, here).value());
  out.push_back(out.back().without("new ball").value());
  out.push_back(out.back().with_box("new crate", small, here).value());
  return out;
}

void append(const std::vector<double>& numbers, std::vector<std::uint8_t>& out) {
  for (const std::byte byte : std::as_bytes(std::span(numbers))) out.push_back(std::to_integer<std::uint8_t>(byte));
}

// Points that the pairs share that collide at some states; and the planes between all others at a few.
void explain(const Checker& checker, const Inputs& given, std::vector<std::uint8_t>& out) {
  const std::size_t nq = checker.nq();
  plannercheck::Workspace workspace;
  for (std::size_t i = 0; i < std::min(kExplained, given.states.size() / nq); ++i) {
    const std::span<const double> q = std::span(given.states).subspan(i * nq, nq);
    const auto verdict = checker.explain(q, workspace, i < kSeparated).value();
    for (const auto& each : verdict.collisions) append({each.point.begin(), each.point.end()}, out);
    for (const auto& each : verdict.separations) {
      const auto& [x, y, z] = each.normal;
      append({each.has_plane ? 1.0 : 0.0, x, y, z, each.offset, each.gap}, out);
    }
  }
}

// Verdicts and control points of trajectories from the start of a motion to its end and back: straight, cubic and
// quintic in turns, every other one with a tube. The same are in tests/benchmarks/cpp_library.py.
void judge_trajectories(const Checker& checker, const Inputs& given, std::vector<std::uint8_t>& out) {
  const std::size_t nq = checker.nq(), count = std::min(kEdited, given.starts.size() / nq);
  const std::array<double, 3> times{0, 1, 2.5};
  const std::vector<double> tube(nq, 0x1p-10);
  plannercheck::Workspace workspace;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> q(3 * nq), v(3 * nq), a(3 * nq);
    for (std::size_t c = 0; c < nq; ++c) {
      const double start = given.starts[i * nq + c], end = given.ends[i * nq + c];
      q[c] = q[2 * nq + c] = start, q[nq + c] = end;
      v[nq + c] = 0.5 * (end - start), a[nq + c] = 0.25 * (end - start);
    }
    if (i % 3 == 0) v.clear();
    if (i % 3 != 2) a.clear();
    const auto executed = plannercheck::Trajectory::executed(times, q, v, a).value();
    const auto around = i % 2 == 0 ? std::span<const double>() : tube;
    const bool free = checker.check_trajectory(executed, workspace, around).value();
    if (checker.explain_trajectory(executed, workspace, around).value().free != free) std::abort();
    out.push_back(free ? 1 : 0);
    for (const auto& numbers : {executed.points, executed.error}) append(numbers, out);
  }
}

// The numbers of the tables of distances within a limit, and of the nearest two pairs, of some states.
void measure(const Checker& checker, const Inputs& given, std::vector<std::uint8_t>& out) {
  const std::size_t nq = checker.nq(), count = std::min<std::size_t>(kMeasured, given.states.size() / nq);
  const std::span<const double> states(given.states.data(), count * nq);
  plannercheck::Workspace workspace;
  for (const std::size_t nearest : {std::size_t{0}, std::size_t{2}}) {
    const std::clock_t begin = std::clock();
    const auto table = checker.distances(states, workspace, 0.125, nearest).value();
    std::printf("%zu distances of %zu states, %.2f us each\n", table.size(), count,
                1e6 * seconds(begin) / static_cast<double>(table.size()));
    for (const plannercheck::Distance& row : table) {
      std::vector<double> numbers{static_cast<double>(row.state), row.distance, row.lower, row.gap,
                                  row.unique ? 1.0 : 0.0};
      for (const auto& vector : {row.on_first, row.on_second, row.normal})
        numbers.insert(numbers.end(), vector.begin(), vector.end());
      numbers.insert(numbers.end(), row.gradient.begin(), row.gradient.end());
      append(numbers, out);
    }
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 6) return 2;
  std::clock_t begin = std::clock();
  const plannercheck::Result<Checker> loaded = Checker::load(arguments[1]);
  if (!loaded.ok()) return std::fprintf(stderr, "%s\n", std::string(loaded.error()).c_str()), 1;
  const Checker& checker = loaded.value();
  std::printf("loaded in %.2f ms, level %s\n", 1e3 * seconds(begin), std::string(checker.level()).c_str());
  const Inputs given{doubles(arguments[2]), doubles(arguments[3]), doubles(arguments[4])};
  std::vector<std::uint8_t> verdicts;
  judge(checker, given, given.states.size(), verdicts, true);
  plannercheck::Workspace workspace;
  for (std::size_t i = 0; i < given.states.size() / checker.nq() && i < 10000; ++i) {  // which other code judges
    const std::span<const double> row(given.states.data() + i * checker.nq(), checker.nq());
    if (checker.is_valid(row, workspace).value() != (verdicts[i] != 0) ||
        (i < 100 && checker.explain(row, workspace).value().valid != (verdicts[i] != 0)))
      return std::fprintf(stderr, "state %zu alone has another verdict\n", i), 1;
  }
  begin = std::clock();
  const std::vector<Checker> others = edited(checker);
  std::printf("an edit takes %.2f ms\n", 1e3 * seconds(begin) / static_cast<double>(others.size()));
  for (const Checker& other : others) judge(other, given, kEdited, verdicts, false);
  explain(checker, given, verdicts);
  for (const Checker& each : {checker, others.front()}) {
    judge_trajectories(each, given, verdicts);
    measure(each, given, verdicts);
  }
  std::ofstream out(arguments[5], std::ios::binary);
  out.write(reinterpret_cast<const char*>(verdicts.data()), static_cast<std::streamsize>(verdicts.size()));
  return 0;
}
