// Edits of the cell of `padded_checker` in tests/benchmarks/cpp_library.py: `edit_scene CELL STATES OUT`.
//
// OUT gets, after each edit, what `told_of` there has of the same scene in Python. All obstacles can go, and a checker
// that was moved from still judges. The exit code is 1, and the line is said, where that is not so.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <plannercheck/checker.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#define CHECK(is_so)                                                                            \
  do {                                                                                          \
    if (!(is_so)) std::printf("%s:%d: not so: %s\n", __FILE__, __LINE__, #is_so), std::exit(1); \
  } while (false)

namespace {

using plannercheck::Checker;

// What of each scene is written.
class Told {
 public:
  explicit Told(const char* path) : out_(path, std::ios::binary) {}

  void verdicts(const Checker& checker, std::span<const double> states) {
    std::vector<std::uint8_t> valid(states.size() / checker.nq()), free(kMotions);
    CHECK(checker.check_states(states, valid, workspace_).ok());
    write(valid);
    const std::span<const double> starts = states.first(kMotions * checker.nq());
    std::vector<double> ends;
    for (const double start : starts) ends.push_back(start + 0.05);
    CHECK(checker.check_motions(starts, ends, free, workspace_).ok());
    write(free);
  }

  // The states, and motions from each to the next, all within the limits.
  void steps(const Checker& checker, std::span<const double> states) {
    std::vector<std::uint8_t> valid(states.size() / checker.nq()), free(kMotions);
    CHECK(checker.check_states(states, valid, workspace_).ok());
    write(valid);
    const std::size_t size = kMotions * checker.nq();
    CHECK(checker.check_motions(states.first(size), states.subspan(checker.nq(), size), free, workspace_).ok());
    write(free);
  }

  void distances(const Checker& checker, std::span<const double> states) {
    for (const auto& row : checker.distances(states.first(kMeasured * checker.nq()), workspace_, 0.125).value()) {
      std::vector<double> numbers{static_cast<double>(row.state), row.distance};
      for (const auto& point : {row.on_first, row.on_second}) numbers.insert(numbers.end(), point.begin(), point.end());
      write(numbers);
    }
  }

 private:
  static constexpr std::size_t kMotions = 200, kMeasured = 500;
  std::ofstream out_;
  plannercheck::Workspace workspace_;

  template <class T>
  void write(const std::vector<T>& values) {
    out_.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
  }
};

bool says(const plannercheck::Result<Checker>& result, const std::string& text) {
  return !result.ok() && result.error().find(text) != std::string_view::npos;
}

std::array<double, 16> shifted(double x, double y, double z) {
  return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1};
}

}  // namespace

int main(int count, char** argv) {
  CHECK(count == 4);
  const auto loaded = Checker::load(argv[1]);
  CHECK(loaded.ok());
  std::vector<double> states;
  std::ifstream file(argv[2], std::ios::binary);
  for (double number = 0; file.read(reinterpret_cast<char*>(&number), sizeof number);) states.push_back(number);
  Told told(argv[3]);

  Checker checker = loaded.value();
  const std::array<double, 16> there{0.36, 0.48, -0.8, 0.31, -0.8, 0.6, 0, -0.37, 0.48, 0.64, 0.6, 0.43, 0, 0, 0, 1};
  for (const char* const name : {"sign", "rack", "pad"}) {
    checker = checker.with_pose(name, there).value();
    told.verdicts(checker, states), told.distances(checker, states);
  }
  const std::array<double, 3> crate{0.25, 0.5, 0.125}, other{0.5, 0.25, 0.25};
  const auto again = [&](const char* name, const std::array<double, 3>& size, const std::array<double, 16>& pose) {
    const Checker without = checker.without(name).value();
    told.verdicts(without, states);
    const Checker replaced = checker.with_box(name, size, pose).value();
    checker = without.with_box(name, size, pose).value();
    told.verdicts(checker, states);
    plannercheck::Workspace workspace;
    std::vector<std::uint8_t> one(states.size() / checker.nq()), two(one.size());
    CHECK(checker.check_states(states, one, workspace).ok() && replaced.check_states(states, two, workspace).ok());
    CHECK(one == two);
  };
  again("crate", crate, shifted(0.5, 0.25, 0.5));
  again("pad", other, shifted(-0.5, -0.25, 0.25));
  again("rack", other, shifted(-0.25, 0.5, 0.5));
  checker = checker.with_pose("rack", there).value();
  told.verdicts(checker, states);

  for (const double far : {1e60, 1e150}) told.steps(checker.with_pose("rack", shifted(far, -far, 0.5)).value(), states);

  Checker none = checker;
  for (const char* const name : {"crate", "pad", "rack", "sign", "seen", "mapped", "dug"})
    none = none.without(name).value();
  std::vector<std::uint8_t> valid(states.size() / checker.nq());
  plannercheck::Workspace workspace;
  CHECK(none.check_states(states, valid, workspace).value() == valid.size());
  CHECK(says(none.without("sign"), "valid are none"));
  CHECK(says(checker.without("panda_link0"),
             "unknown object 'panda_link0': valid are sign, seen, mapped, dug, crate, pad, rack"));
  CHECK(says(Checker::load("/"), "it is a folder"));

  const Checker moved = std::move(checker);
  CHECK(checker.is_valid({states.data(), checker.nq()}, workspace).ok());
  CHECK(moved.is_valid({states.data(), moved.nq()}, workspace).ok());
  std::printf("edits of %zu states: as they have to be\n", valid.size());
}
