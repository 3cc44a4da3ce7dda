// Judges configurations and motions of a prepared cell, for comparison with Python: judge CELL STATES STARTS ENDS OUT.
// Inputs are files of doubles; OUT gets a byte for each state and one for each motion. Prints processor times.
#include <cstdio>
#include <ctime>
#include <fstream>
#include <plannercheck/checker.hpp>
#include <string>
#include <vector>

namespace {

std::vector<double> doubles(const char* path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<double> out(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size() * sizeof(double)));
  return out;
}

double seconds(std::clock_t begin) { return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC; }

}  // namespace

int main(int count, char** arguments) {
  if (count != 6) return 2;
  std::clock_t begin = std::clock();
  const plannercheck::Result<plannercheck::Checker> loaded = plannercheck::Checker::load(arguments[1]);
  if (!loaded.ok()) return std::fprintf(stderr, "%s\n", std::string(loaded.error()).c_str()), 1;
  const plannercheck::Checker& checker = loaded.value();
  std::printf("loaded in %.2f ms, level %s\n", 1e3 * seconds(begin), std::string(checker.level()).c_str());
  const std::vector<double> q = doubles(arguments[2]), starts = doubles(arguments[3]), ends = doubles(arguments[4]);
  std::vector<std::uint8_t> valid(q.size() / checker.nq()), free(starts.size() / checker.nq());
  plannercheck::Workspace workspace;
  begin = std::clock();
  const std::size_t valid_count = checker.check_states(q, valid, workspace).value();
  std::printf("%zu of %zu states valid, %.3f us each\n", valid_count, valid.size(),
              1e6 * seconds(begin) / static_cast<double>(valid.size()));
  begin = std::clock();
  const std::size_t free_count = checker.check_motions(starts, ends, free, workspace).value();
  std::printf("%zu of %zu motions free, %.3f us each\n", free_count, free.size(),
              1e6 * seconds(begin) / static_cast<double>(free.size()));
  for (std::size_t i = 0; i < valid.size() && i < 10000; ++i) {  // one by one, which other code judges
    const std::span<const double> row(q.data() + i * checker.nq(), checker.nq());
    if (checker.is_valid(row, workspace).value() != (valid[i] != 0)) return std::fprintf(stderr, "state %zu\n", i), 1;
  }
  std::ofstream out(arguments[5], std::ios::binary);
  out.write(reinterpret_cast<const char*>(valid.data()), static_cast<std::streamsize>(valid.size()));
  out.write(reinterpret_cast<const char*>(free.data()), static_cast<std::streamsize>(free.size()));
  return 0;
}
