// The face of the library: inputs are checked as plannercheck/robots/configurations.py does, then an engine judges.
// Nothing that is thrown behind it gets past `guarded`.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <new>
#include <plannercheck/checker.hpp>
#include <sstream>
#include <stdexcept>

#include "library/engine.hpp"
#include "library/nearest_turns.hpp"

namespace plannercheck {
namespace {

// What is wrong with a call, in whole sentences.
class CallError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The result of a call, or an error of what it throws.
template <class T, class Call>
Result<T> guarded(Call call) noexcept {
  try {
    return call();
  } catch (const std::bad_alloc&) {
    return Error{"out of memory"};
  } catch (const std::exception& error) {
    return Error{error.what()};
  } catch (...) {
    return Error{"unknown failure"};
  }
}

std::string listed(std::span<const double> row) {
  std::ostringstream out;
  out.precision(17);
  out << '[';
  for (std::size_t k = 0; k < row.size(); ++k) out << (k > 0 ? ", " : "") << row[k];
  out << ']';
  return out.str();
}

// Bytes at an address that doubles may have.
struct Bytes {
  std::vector<double> storage;
  std::size_t size;

  explicit Bytes(std::size_t count) : storage((count + sizeof(double) - 1) / sizeof(double)), size(count) {}
  std::byte* data() { return reinterpret_cast<std::byte*>(storage.data()); }
};

Bytes bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff end = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (end < 0) throw CallError("can't read a cell from " + path + ": " + std::strerror(errno));
  Bytes bytes(static_cast<std::size_t>(end));
  file.seekg(0);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), end)) throw CallError("can't read a cell from " + path);
  return bytes;
}

}  // namespace

void end_without_value(const Error& error) noexcept {
  std::fprintf(stderr, "plannercheck: %s\n", error.message.c_str());
  std::abort();
}

struct Checker::Impl {
  const Level& level;
  std::unique_ptr<const Engine> made;
  const PreparedCell* cell;

  Impl(Bytes bytes, const std::string& name)
      : level(chosen_level()), made(level.make({bytes.data(), bytes.size}, name)), cell(&made->cell()) {}

  Impl(const Impl& before, const Edit& edit)
      : level(before.level), made(before.made->edited(edit)), cell(&made->cell()) {}

  const Engine& engine() const { return *made; }
  std::size_t width() const { return cell->width(); }

  void check_width(std::span<const double> q, std::size_t n) const {
    if (q.size() == n * width()) return;
    throw CallError("configurations must have shape (" + std::to_string(n) + ", " + std::to_string(width()) +
                    "), not " + std::to_string(q.size()) + " numbers");
  }

  // The pairs that judge a configuration; an error if it can't be judged.
  Table table_of(const double* q, std::size_t row) const {
    bool within = true, usable = true;
    for (std::size_t k = 0; k < width(); ++k) {
      within &= cell->lower[k] <= q[k] && q[k] <= cell->upper[k];
      usable &= std::fabs(q[k]) <= cell->largest_value;  // false for NaN
    }
    if (!usable) refuse_numbers(q, row);
    for (const auto& [first, past] : cell->unit_parts) check_unit(q, first, past, row);
    return within || !cell->has_limits ? Table::kWithinLimits : Table::kAll;
  }

  // The same of a motion to an end, as given and as `turned`.
  Table table_of_motion(const double* start, const double* given, const double* end, std::size_t row) const {
    const bool within = table_of(start, row) == Table::kWithinLimits && table_of(given, row) == Table::kWithinLimits &&
                        table_of(end, row) == Table::kWithinLimits;
    for (std::size_t k = 0; k < width(); ++k) {
      const double least = std::min({start[k], given[k], end[k]}), largest = std::max({start[k], given[k], end[k]});
      if (least < cell->usual_low[k] || largest > cell->usual_high[k]) refuse_range(row, k);
    }
    return within ? Table::kWithinLimits : Table::kAll;
  }

  [[noreturn]] void refuse_range(std::size_t row, std::size_t column) const {
    throw CallError("motion " + std::to_string(row) + ": column " + std::to_string(column) + " leaves " +
                    listed(std::array{cell->usual_low[column], cell->usual_high[column]}) +
                    ", in which the cell's bound of rounding holds: take whole turns off, or check it in Python");
  }

  // The ends of motions, whose angles take the shorter turn: the given ones, or those that are written to `ends`.
  const double* turned(std::span<const double> q0, std::span<const double> q1, std::vector<double>& ends) const {
    if (cell->turning_columns.empty()) return q1.data();
    ends.assign(q1.begin(), q1.end());
    for (std::size_t row = 0; row < q1.size(); row += width()) {
      for (const std::size_t column : cell->turning_columns)
        ends[row + column] = nearest_turn(q0[row + column], q1[row + column]);
    }
    return ends.data();
  }

  NamedPair named(std::size_t row) const {
    const auto& [a, b] = cell->pairs[row];
    return {cell->body_names[at(a)], cell->body_names[at(b)]};
  }

  [[noreturn]] void refuse_numbers(const double* q, std::size_t row) const {
    char largest[32];
    std::snprintf(largest, sizeof largest, "%g", cell->largest_value);
    throw CallError("configurations must be finite (and at most " + std::string(largest) + "); row " +
                    std::to_string(row) + " is " + listed({q, width()}));
  }

  void check_unit(const double* q, std::size_t first, std::size_t past, std::size_t row) const {
    double square = 0;
    for (std::size_t k = first; k < past; ++k) square += q[k] * q[k];
    if (std::fabs(square - 1) <= cell->unit_tolerance) return;
    throw CallError("columns " + std::to_string(first) + " to " + std::to_string(past - 1) + " are " +
                    (past - first == 4 ? "a quaternion" : "cosine and sine") + ", of length 1; in row " +
                    std::to_string(row) + " it is " + listed({q + first, past - first}) +
                    ": normalise it in double precision");
  }
};

struct Workspace::State {
  std::shared_ptr<const void> of;  // the checker whose scratch it is
  std::unique_ptr<Engine::Scratch> scratch;
  std::vector<double> ends, some_starts, some_ends;
  std::array<std::vector<std::size_t>, 2> rows;  // by table
  std::vector<std::uint8_t> answers;
};

namespace {

constexpr std::array<Table, 2> kTables{Table::kWithinLimits, Table::kAll};

std::size_t index_of(Table table) { return static_cast<std::size_t>(table); }

// The given rows of some numbers, one after the other.
void gather(const double* from, std::size_t width, const std::vector<std::size_t>& rows, std::vector<double>& to) {
  to.resize(rows.size() * width);
  for (std::size_t i = 0; i < rows.size(); ++i) std::copy_n(from + rows[i] * width, width, to.data() + i * width);
}

std::size_t count_ones(std::span<const std::uint8_t> flags) {
  return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), std::uint8_t{1}));
}

void check_tolerance(double tolerance) {
  if (tolerance > 0 && std::isfinite(tolerance)) return;
  std::ostringstream words;
  words << "tolerance must be a positive length in m, not " << tolerance;
  throw CallError(words.str());
}

void check_precise(MotionAnswer answer, std::size_t row, double tolerance) {
  if (answer != MotionAnswer::kImprecise) return;
  std::ostringstream words;
  words << "motion " << row << ": lengths and angles are so large that rounding is no small part of the tolerance of "
        << tolerance << " m; choose a larger tolerance, or smaller numbers";
  throw CallError(words.str());
}

Edit edit_of(Edit::Kind kind, const std::string& name, Checker::Pose pose) {
  constexpr std::array<double, 4> kLastRow{0, 0, 0, 1};
  if (!std::equal(kLastRow.begin(), kLastRow.end(), pose.begin() + 12))
    throw CallError("obstacle '" + name + "': the last row of a pose must be 0, 0, 0, 1");
  Edit edit{kind, name, {}, {}};
  std::copy_n(pose.begin(), edit.pose.m.size(), edit.pose.m.begin());
  return edit;
}

std::vector<Vec3> points_of(const std::string& name, std::span<const double> numbers) {
  if (numbers.size() % 3 != 0)
    throw CallError("obstacle '" + name + "': points must be three numbers each, not " +
                    std::to_string(numbers.size()) + " in all");
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < numbers.size(); i += 3) points.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return points;
}

const ChainedTable& chained(const PreparedCell& cell, Table table) {
  return table == Table::kAll && cell.has_limits ? cell.all : cell.within_limits;
}

}  // namespace

Workspace::Workspace() noexcept = default;
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

Checker::Checker(std::shared_ptr<const Impl> impl) noexcept : impl_(std::move(impl)) {}
Checker::Checker(const Checker&) noexcept = default;
Checker::Checker(Checker&&) noexcept = default;
Checker& Checker::operator=(const Checker&) noexcept = default;
Checker& Checker::operator=(Checker&&) noexcept = default;
Checker::~Checker() = default;

Result<Checker> Checker::load(const std::string& path) noexcept {
  return guarded<Checker>([&] { return Checker(std::make_shared<const Impl>(bytes_of(path), path)); });
}

Result<Checker> Checker::parse(std::span<const std::byte> file) noexcept {
  return guarded<Checker>([&] {
    Bytes bytes(file.size());
    std::copy(file.begin(), file.end(), bytes.data());
    return Checker(std::make_shared<const Impl>(std::move(bytes), "the file"));
  });
}

std::size_t Checker::nq() const noexcept { return impl_->width(); }
std::span<const double> Checker::lower() const noexcept { return impl_->cell->lower; }
std::span<const double> Checker::upper() const noexcept { return impl_->cell->upper; }
std::span<const std::size_t> Checker::continuous_columns() const noexcept { return impl_->cell->turning_columns; }
const std::string& Checker::robot_name() const noexcept { return impl_->cell->robot; }
const std::string& Checker::scene_name() const noexcept { return impl_->cell->scene; }
const std::vector<std::string>& Checker::joint_names() const noexcept { return impl_->cell->joint_names; }
const std::vector<std::string>& Checker::link_names() const noexcept { return impl_->cell->link_names; }
const std::string& Checker::about() const noexcept { return impl_->cell->about; }
std::string_view Checker::level() const noexcept { return impl_->level.name; }

Workspace::State& Checker::state_of(Workspace& workspace) const {
  if (workspace.state_ == nullptr) workspace.state_ = std::make_unique<Workspace::State>();
  Workspace::State& state = *workspace.state_;
  if (state.of != impl_) {
    state.scratch = impl_->engine().new_scratch();
    state.of = impl_;
  }
  return state;
}

Result<Checker> Checker::with_box(const std::string& name, std::span<const double, 3> size, Pose pose) const noexcept {
  return guarded<Checker>([&] {
    for (const double edge : size) {
      if (!(edge > 0)) throw CallError("box '" + name + "': edge lengths must be positive, m, not " + listed(size));
    }
    Edit edit = edit_of(Edit::Kind::kHull, name, pose);
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        for (const double z : {-0.5, 0.5}) edit.points.push_back({x * size[0], y * size[1], z * size[2]});
      }
    }
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_sphere(const std::string& name, double radius,
                                     std::span<const double, 3> centre) const noexcept {
  return guarded<Checker>([&] {
    Edit edit{Edit::Kind::kHull, name, {}, {{0, 0, 0}}, radius};
    edit.pose.m[3] = centre[0], edit.pose.m[7] = centre[1], edit.pose.m[11] = centre[2];
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_hull(const std::string& name, std::span<const double> points, Pose pose) const noexcept {
  return guarded<Checker>([&] {
    Edit edit = edit_of(Edit::Kind::kHull, name, pose);
    edit.points = points_of(name, points);
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_cloud(const std::string& name, std::span<const double> points, double radius,
                                    Pose pose) const noexcept {
  return guarded<Checker>([&] {
    Edit edit = edit_of(Edit::Kind::kCloud, name, pose);
    edit.points = points_of(name, points), edit.radius = radius;
    return Checker(std::make_shared<const Impl>(*impl_, edit));
  });
}

Result<Checker> Checker::with_pose(const std::string& name, Pose pose) const noexcept {
  return guarded<Checker>(
      [&] { return Checker(std::make_shared<const Impl>(*impl_, edit_of(Edit::Kind::kMove, name, pose))); });
}

Result<Checker> Checker::without(const std::string& name) const noexcept {
  return guarded<Checker>(
      [&] { return Checker(std::make_shared<const Impl>(*impl_, Edit{Edit::Kind::kRemove, name, {}, {}})); });
}

Result<bool> Checker::is_valid(std::span<const double> q, Workspace& workspace) const noexcept {
  return guarded<bool>([&] {
    impl_->check_width(q, 1);
    const Table table = impl_->table_of(q.data(), 0);
    std::uint8_t valid = 0;
    impl_->engine().check_states(table, q.data(), 1, &valid, *state_of(workspace).scratch);
    return valid != 0;
  });
}

Result<std::size_t> Checker::check_states(std::span<const double> q, std::span<std::uint8_t> valid,
                                          Workspace& workspace) const noexcept {
  return guarded<std::size_t>([&] {
    const std::size_t n = valid.size(), width = impl_->width();
    impl_->check_width(q, n);
    Workspace::State& state = state_of(workspace);
    for (auto& rows : state.rows) rows.clear();
    for (std::size_t i = 0; i < n; ++i) state.rows[index_of(impl_->table_of(q.data() + i * width, i))].push_back(i);
    for (const Table table : kTables) {
      const std::vector<std::size_t>& rows = state.rows[index_of(table)];
      if (rows.empty()) continue;
      if (rows.size() == n) {
        impl_->engine().check_states(table, q.data(), n, valid.data(), *state.scratch);
        continue;
      }
      gather(q.data(), width, rows, state.some_starts);
      state.answers.resize(rows.size());
      impl_->engine().check_states(table, state.some_starts.data(), rows.size(), state.answers.data(), *state.scratch);
      for (std::size_t i = 0; i < rows.size(); ++i) valid[rows[i]] = state.answers[i];
    }
    return count_ones(valid);
  });
}

Result<bool> Checker::check_motion(std::span<const double> q0, std::span<const double> q1, Workspace& workspace,
                                   double tolerance) const noexcept {
  std::uint8_t free = 0;
  Result<std::size_t> found = check_motions(q0, q1, {&free, 1}, workspace, tolerance);
  if (!found.ok()) return Error{std::string(found.error())};
  return free != 0;
}

Result<std::size_t> Checker::check_motions(std::span<const double> q0, std::span<const double> q1,
                                           std::span<std::uint8_t> free, Workspace& workspace,
                                           double tolerance) const noexcept {
  return guarded<std::size_t>([&] {
    const std::size_t n = free.size(), width = impl_->width();
    check_tolerance(tolerance);
    impl_->check_width(q0, n), impl_->check_width(q1, n);
    Workspace::State& state = state_of(workspace);
    const double* const ends = impl_->turned(q0, q1, state.ends);
    for (auto& rows : state.rows) rows.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t from = i * width;
      const Table table = impl_->table_of_motion(q0.data() + from, q1.data() + from, ends + from, i);
      state.rows[index_of(table)].push_back(i);
    }
    for (const Table table : kTables) {
      const std::vector<std::size_t>& rows = state.rows[index_of(table)];
      if (rows.empty()) continue;
      if (!chained(*impl_->cell, table).touching.empty()) {  // at every state, so no motion is free
        for (const std::size_t row : rows) free[row] = 0;
        continue;
      }
      const double *some_starts = q0.data(), *some_ends = ends;
      if (rows.size() != n) {
        gather(q0.data(), width, rows, state.some_starts), gather(ends, width, rows, state.some_ends);
        some_starts = state.some_starts.data(), some_ends = state.some_ends.data();
      }
      state.answers.resize(rows.size());
      impl_->engine().check_motions(table, some_starts, some_ends, rows.size(), tolerance, state.answers.data(),
                                    *state.scratch);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto answer = static_cast<MotionAnswer>(state.answers[i]);
        check_precise(answer, rows[i], tolerance);
        free[rows[i]] = answer == MotionAnswer::kFree ? 1 : 0;
      }
    }
    return count_ones(free);
  });
}

Result<Verdict> Checker::explain(std::span<const double> q, Workspace& workspace) const noexcept {
  return guarded<Verdict>([&] {
    impl_->check_width(q, 1);
    static_cast<void>(impl_->table_of(q.data(), 0));
    Workspace::State& state = state_of(workspace);
    state.answers.assign(impl_->cell->pairs.size(), 0);
    impl_->engine().colliding_pairs(q.data(), state.answers.data(), *state.scratch);
    Verdict verdict;
    for (std::size_t k = 0; k < state.answers.size(); ++k) {
      if (state.answers[k] != 0) verdict.collisions.push_back(impl_->named(k));
    }
    verdict.valid = verdict.collisions.empty();
    return verdict;
  });
}

Result<MotionVerdict> Checker::explain_motion(std::span<const double> q0, std::span<const double> q1,
                                              Workspace& workspace, double tolerance) const noexcept {
  return guarded<MotionVerdict>([&] {
    check_tolerance(tolerance);
    impl_->check_width(q0, 1), impl_->check_width(q1, 1);
    Workspace::State& state = state_of(workspace);
    const double* const end = impl_->turned(q0, q1, state.ends);
    const Table table = impl_->table_of_motion(q0.data(), q1.data(), end, 0);
    const std::vector<std::int32_t>& touching = chained(*impl_->cell, table).touching;
    if (!touching.empty()) return MotionVerdict{false, 0, -1, impl_->named(at(touching[0]))};
    const MotionReport report = impl_->engine().explain_motion(table, q0.data(), end, tolerance, *state.scratch);
    check_precise(report.answer, 0, tolerance);
    if (report.answer == MotionAnswer::kFree) return MotionVerdict{};
    return MotionVerdict{false, report.free_until, report.refused, impl_->named(at(report.pair))};
  });
}

}  // namespace plannercheck
