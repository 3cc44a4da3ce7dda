// Edits of the cell of `padded_cell` in tests/benchmarks/cpp_library.py: `edit_scene CELL STATES`.
//
// A crate keeps its padding when it is replaced by itself, a body with a pose of its own does not move, and all
// obstacles can go. The exit code is 1, and the line is said, where that is not so.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <plannercheck/checker.hpp>
#include <string>
#include <utility>
#include <vector>

#define CHECK(is_so)                                                                            \
  do {                                                                                          \
    if (!(is_so)) std::printf("%s:%d: not so: %s\n", __FILE__, __LINE__, #is_so), std::exit(1); \
  } while (false)

namespace {

using plannercheck::Checker;

std::vector<std::uint8_t> verdicts(const Checker& checker, const std::vector<double>& states) {
  plannercheck::Workspace workspace;
  std::vector<std::uint8_t> valid(states.size() / checker.nq());
  CHECK(checker.check_states(states, valid, workspace).ok());
  return valid;
}

bool says(const plannercheck::Result<Checker>& result, const std::string& text) {
  return !result.ok() && result.error().find(text) != std::string_view::npos;
}

}  // namespace

int main(int, char** argv) {
  const auto loaded = Checker::load(argv[1]);
  CHECK(loaded.ok());
  Checker checker = loaded.value();
  std::vector<double> states;
  std::ifstream file(argv[2], std::ios::binary);
  for (double number = 0; file.read(reinterpret_cast<char*>(&number), sizeof number);) states.push_back(number);
  states.resize(states.size() / checker.nq() * checker.nq());

  const std::array<double, 16> here{1, 0, 0, 0.5, 0, 1, 0, 0.25, 0, 0, 1, 0.5, 0, 0, 0, 1};
  const std::array<double, 3> size{0.25, 0.5, 0.125};
  const auto found = verdicts(checker, states);
  CHECK(verdicts(checker.with_pose("crate", here).value(), states) == found);
  CHECK(verdicts(checker.with_box("crate", size, here).value(), states) == found);
  CHECK(says(checker.with_pose("sign", here), "'sign' has a shape with a pose of its own"));
  CHECK(checker.with_box("sign", size, here).value().with_pose("sign", here).ok());

  const Checker without = checker.without("sign").value();
  CHECK(verdicts(without.without("crate").value(), states) == std::vector<std::uint8_t>(found.size(), 1));
  CHECK(without.without("sign").error() == "unknown obstacle 'sign': there is crate");
  CHECK(says(checker.without(""), "must have a name"));
  CHECK(says(Checker::load("/"), "it is a folder"));

  const Checker other = std::move(checker);
  CHECK(verdicts(checker, states) == found && verdicts(other, states) == found);
  std::printf("edits of %zu states: as they have to be\n", found.size());
}
