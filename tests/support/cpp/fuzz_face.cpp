// libFuzzer's target for the face: one cell, given in PLANNERCHECK_CELL, and calls that the input spells. Under the
// sanitizers, whatever numbers, shapes and edits are asked for, a call ends with a value or an error. An input whose
// first byte is odd is instead taken for a cell's file of its own, with the right size and checksum put in.
// `python tests/benchmarks/cpp_library.py --face 3600` builds and runs it.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <plannercheck/checker.hpp>
#include <span>
#include <string>
#include <vector>

#include "signed_cell.hpp"

namespace {

using plannercheck::Checker;

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  bool is_empty() const { return size_ == 0; }
  std::uint8_t byte() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  // Any double, but mostly one that a joint may have.
  double number() {
    const std::uint8_t kind = byte();
    double out = 0;
    if (kind % 4 == 0 && size_ >= sizeof out) {
      std::memcpy(&out, data_, sizeof out);
      data_ += sizeof out, size_ -= sizeof out;
      return out;
    }
    return (byte() - 128) / (kind % 4 == 1 ? 32.0 : 128.0);
  }
  std::vector<double> numbers(std::size_t count) {
    std::vector<double> out;
    while (out.size() < count) out.push_back(number());
    return out;
  }
  // Nearly always as many numbers as are asked for.
  std::vector<double> row(std::size_t count) { return numbers(byte() < 4 ? byte() % 16 : count); }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

std::array<double, 16> pose(Input& in) {
  std::array<double, 16> out{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  for (const unsigned k : {3U, 7U, 11U}) out[k] = in.number();
  if (in.byte() % 8 == 0) out[in.byte() % 16] = in.number();
  return out;
}

// Some edit, if it is none that is refused.
void edit(Checker& checker, Input& in) {
  static const char* const kNames[] = {"hull", "new", "floor", ""};
  const std::string name = kNames[in.byte() % 4];
  const auto at = pose(in);
  const std::vector<double> points = in.row(3 * (in.byte() % 12U));
  const std::array<double, 3> size{in.number(), in.number(), in.number()};
  plannercheck::Result<Checker> made = [&] {
    switch (in.byte() % 6) {
      case 0:
        return checker.with_box(name, size, at);
      case 1:
        return checker.with_sphere(name, in.number(), size);
      case 2:
        return checker.with_hull(name, points, at);
      case 3:
        return checker.with_cloud(name, points, in.number(), at);
      case 4:
        return checker.with_pose(name, at);
      default:
        return checker.without(name);
    }
  }();
  if (made.ok()) checker = std::move(made).value();
}

void call(Checker& checker, plannercheck::Workspace& workspace, Input& in) {
  const std::size_t nq = checker.nq();
  std::vector<std::uint8_t> flags(in.byte() % 6U);
  switch (in.byte() % 8) {
    case 0:
      static_cast<void>(checker.is_valid(in.row(nq), workspace));
      return;
    case 1:
      static_cast<void>(checker.check_states(in.row(nq * flags.size()), flags, workspace));
      return;
    case 2: {
      const std::vector<double> q0 = in.row(nq * flags.size()), q1 = in.row(nq * flags.size());
      static_cast<void>(checker.check_motions(q0, q1, flags, workspace, in.byte() % 4 == 0 ? in.number() : 1e-3));
      return;
    }
    case 3: {
      const std::vector<double> q0 = in.row(nq);
      static_cast<void>(checker.explain_motion(q0, in.row(nq), workspace, 1e-3));
      return;
    }
    case 4:
      static_cast<void>(checker.explain(in.row(nq), workspace, true));
      return;
    case 5: {
      const std::vector<double> q = in.row(nq * flags.size());
      static_cast<void>(
          checker.distances(q, workspace, in.byte() % 4 == 0 ? in.number() : 0.125, in.byte() % 4 == 0 ? 3 : 0));
      return;
    }
    case 6: {
      const std::size_t n = flags.size();
      std::vector<double> times;
      for (std::size_t k = 0; k < n; ++k) times.push_back(static_cast<double>(k) + in.number() / 8);
      const std::vector<double> q = in.row(n * nq);
      std::vector<double> v = in.row(in.byte() % 2 == 0 ? n * nq : 0);
      if (v.size() >= nq && in.byte() % 8 != 0) std::fill(v.end() - static_cast<std::ptrdiff_t>(nq), v.end(), 0.0);
      const std::vector<double> a = in.row(in.byte() % 2 == 0 ? n * nq : 0);
      auto made = plannercheck::Trajectory::executed(times, q, v, a);
      if (!made.ok()) return;
      plannercheck::Trajectory trajectory = std::move(made).value();
      if (in.byte() % 8 == 0) trajectory.degrees[0] = in.byte();
      if (in.byte() % 8 == 0 && !trajectory.points.empty()) trajectory.points[0] = in.number();
      const std::vector<double> tube = in.byte() % 4 == 0 ? in.row(nq) : std::vector<double>{};
      static_cast<void>(checker.check_trajectory(trajectory, workspace, tube, 1e-3));
      static_cast<void>(checker.explain_trajectory(trajectory, workspace, tube, 1e-3));
      return;
    }
    default:
      edit(checker, in);
  }
}

const Checker& given_cell() {
  static const Checker checker = [] {
    const char* const path = std::getenv("PLANNERCHECK_CELL");
    return Checker::load(path == nullptr ? "cell.plannercheck" : path).value();
  }();
  return checker;
}

void parse(const std::uint8_t* data, std::size_t size) {
  std::vector<char> file(data, data + size);
  sign(file);
  auto parsed = Checker::parse(std::as_bytes(std::span(file)));
  if (!parsed.ok()) return;
  const Checker checker = std::move(parsed).value();
  plannercheck::Workspace workspace;
  static_cast<void>(checker.is_valid(std::vector<double>(checker.nq(), 0.25), workspace));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0 && data[0] % 2 == 1) return parse(data + 1, size - 1), 0;
  Input in(data, size);
  in.byte();
  Checker checker = given_cell();
  plannercheck::Workspace workspace;
  for (int calls = 0; calls < 16 && !in.is_empty(); ++calls) call(checker, workspace, in);
  return 0;
}
