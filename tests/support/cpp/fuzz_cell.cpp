// Damaged cells: fuzz_cell CELL COUNT SEED changes bytes of a cell, or cuts it short, COUNT times. Half of the files
// get the right checksum again, as a hostile file has it. Each is refused, or judges some configurations and motions;
// under the sanitizers, no step may leave its memory. Prints how many were refused, and the slowest file's time.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <plannercheck/checker.hpp>
#include <random>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "signed_cell.hpp"

namespace {

using Random = std::mt19937_64;

constexpr std::size_t kCountAt = 32, kEntry = 64, kShapeAt = 32;

std::size_t below(Random& random, std::size_t end) {
  return std::uniform_int_distribution<std::size_t>(0, end - 1)(random);
}

// A place in the file: anywhere, or in the numbers of a section, since large sections would get nearly all others.
std::size_t place(const Bytes& file, Random& random) {
  const auto sections = get<std::uint32_t>(file, kCountAt);
  if (sections == 0 || below(random, 4) == 0) return below(random, file.size());
  const std::size_t entry = kHeader + below(random, sections) * kEntry;
  if (below(random, 8) == 0) return entry + below(random, kEntry);
  const auto columns = get<std::uint32_t>(file, entry + kShapeAt + 4);
  const auto rows = get<std::uint64_t>(file, entry + kShapeAt + 8),
             offset = get<std::uint64_t>(file, entry + kShapeAt + 16);
  const auto width = get<std::uint32_t>(file, entry + kShapeAt) == 3   ? 8U
                     : get<std::uint32_t>(file, entry + kShapeAt) == 2 ? 4U
                                                                       : 1U;
  const std::size_t numbers = columns * rows;
  return numbers == 0 ? entry + below(random, kEntry) : offset + width * below(random, numbers);
}

void change(Bytes& file, Random& random) {
  const std::size_t at = place(file, random);
  if (at >= file.size()) return;
  switch (below(random, 6)) {
    case 0:
      file[at] = static_cast<char>(file[at] ^ 1 << below(random, 8));
      break;
    case 1:
      file[at] = static_cast<char>(random());
      break;
    case 2:
      put(file, at, static_cast<std::int32_t>(below(random, 5)) - 2);
      break;
    case 3:
      put(file, at, static_cast<std::int32_t>(random()));
      break;
    case 4: {
      const double numbers[] = {0, -1, 1e300, -1e300, 1e-310, 1.0 / 3, std::strtod("nan", nullptr), HUGE_VAL};
      put(file, at, numbers[below(random, std::size(numbers))]);
      break;
    }
    default:
      put(file, at, get<double>(file, at) * std::uniform_real_distribution<>(-2, 2)(random));
  }
}

// First and past columns of the unit vectors of configurations, from the section of a sound file.
std::vector<std::int32_t> unit_columns(const Bytes& file) {
  std::vector<std::int32_t> out;
  for (std::size_t k = 0; k < get<std::uint32_t>(file, kCountAt); ++k) {
    const std::size_t entry = kHeader + k * kEntry;
    if (std::strncmp(file.data() + entry, "unit columns", kShapeAt) != 0) continue;
    const auto rows = get<std::uint64_t>(file, entry + kShapeAt + 8),
               offset = get<std::uint64_t>(file, entry + kShapeAt + 16);
    for (std::size_t i = 0; i < 2 * rows; ++i) out.push_back(get<std::int32_t>(file, offset + 4 * i));
  }
  return out;
}

void make_unit(std::span<double> numbers) {
  double square = 0;
  for (const double number : numbers) square += number * number;
  for (double& number : numbers) number /= std::sqrt(square);
}

// The scene's obstacles go elsewhere, and out and in again, of which the first has a state judged.
void edit(const plannercheck::Checker& checker, std::span<const double> row) {
  const std::array<double, 16> pose{1, 0, 0, 0.25, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1};
  const std::array<double, 3> size{0.25, 0.5, 0.125};
  plannercheck::Workspace workspace;
  plannercheck::Checker other = checker;
  for (const char* const name : {"hull", "plane", "new"}) {
    for (auto made : {other.with_pose(name, pose), other.without(name), other.with_box(name, size, pose)}) {
      if (made.ok()) static_cast<void>((other = std::move(made).value()).is_valid(row, workspace));
    }
  }
}

std::size_t judged = 0;  // files whose states had verdicts

// Judges a few states and motions of a cell that was accepted.
void judge(const plannercheck::Checker& checker, const std::vector<std::int32_t>& units, Random& random) {
  constexpr std::size_t kStates = 20, kMotions = 3;
  std::vector<double> q;
  for (std::size_t i = 0; i < kStates * checker.nq(); ++i) q.push_back(std::uniform_real_distribution<>(-2, 2)(random));
  for (std::size_t i = 0; i < kStates; ++i) {
    for (std::size_t k = 0; k + 1 < units.size(); k += 2) {
      const auto first = static_cast<std::size_t>(units[k]), past = static_cast<std::size_t>(units[k + 1]);
      if (past <= checker.nq()) make_unit(std::span(q).subspan(i * checker.nq() + first, past - first));
    }
  }
  std::vector<std::uint8_t> answers(kStates), free(kMotions);
  plannercheck::Workspace workspace;
  judged += checker.check_states(q, answers, workspace).ok();
  const std::span<const double> all(q), row = all.first(checker.nq()), few = all.first(kMotions * checker.nq());
  static_cast<void>(checker.is_valid(row, workspace));
  static_cast<void>(checker.explain(row, workspace, true));
  static_cast<void>(checker.check_motions(few, all.last(few.size()), free, workspace, 0.05));
  static_cast<void>(checker.explain_motion(row, few.last(checker.nq()), workspace, 0.05));
  edit(checker, row);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) return 2;
  std::ifstream stream(arguments[1], std::ios::binary);
  const Bytes whole{std::istreambuf_iterator<char>(stream), {}};
  Random random(std::strtoull(arguments[3], nullptr, 10));
  const std::vector<std::int32_t> units = unit_columns(whole);
  std::size_t refused = 0, signed_files = 0, signed_refused = 0;
  double slowest = 0;
  std::set<std::string> sentences;
  const std::size_t files = std::strtoull(arguments[2], nullptr, 10);
  for (std::size_t i = 0; i < files; ++i) {
    Bytes file = whole;
    if (below(random, 8) == 0) file.resize(below(random, file.size()));
    if (!file.empty()) {
      for (std::size_t k = 0; k <= below(random, 3); ++k) change(file, random);
    }
    const bool is_signed = below(random, 2) == 0;
    if (is_signed) sign(file);
    const auto begin = std::chrono::steady_clock::now();
    const auto read = plannercheck::Checker::parse(std::as_bytes(std::span(file)));
    if (read.ok()) judge(read.value(), units, random);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (took > slowest) slowest = took;
    signed_files += is_signed, refused += !read.ok(), signed_refused += is_signed && !read.ok();
    if (!read.ok()) sentences.insert(std::string(read.error()));
    if (!is_signed && read.ok() && file != whole) return std::fprintf(stderr, "file %zu was accepted\n", i), 1;
  }
  std::printf(
      "%zu files: %zu refused; of %zu with the right checksum %zu, in %zu sentences; %zu gave verdicts; slowest %.2f "
      "s\n",
      files, refused, signed_files, signed_refused, sentences.size(), judged, slowest);
  return 0;
}
