// Judges configurations and motions of a prepared cell, for comparison with Python: judge CELL STATES STARTS ENDS OUT.
// Inputs are files of doubles. OUT gets a byte for each state and one for each motion; then the same of the first
// kEdited ones after each of some edits of the scene. Prints processor times.
#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <plannercheck/checker.hpp>
#include <string>
#include <vector>

namespace {

using plannercheck::Checker;

constexpr std::size_t kEdited = 2000;

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
  std::ofstream out(arguments[5], std::ios::binary);
  out.write(reinterpret_cast<const char*>(verdicts.data()), static_cast<std::streamsize>(verdicts.size()));
  return 0;
}
