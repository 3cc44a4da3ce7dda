// The face of the library: files are read, and verdicts asked of an engine.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>

#include "library/checker_impl.hpp"

namespace plannercheck {
namespace {

Bytes bytes_of(const std::string& path) {
  const auto refused = [&](const char* why) { return CallError("can't read a cell from " + path + ": " + why); };
  std::error_code unknown;  // then opening the file says what is wrong
  const std::filesystem::file_status found = std::filesystem::status(path, unknown);
  if (is_directory(found)) throw refused("it is a folder");
  if (!unknown && !is_regular_file(found)) throw refused("it is a pipe or a device");  // opening it may never end
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff end = file ? static_cast<std::streamoff>(file.tellg()) : -1;
  if (end < 0) throw refused(std::strerror(errno));
  const auto first = [&](std::streamoff size) {
    Bytes bytes(static_cast<std::size_t>(size));
    file.seekg(0);
    if (!file.read(reinterpret_cast<char*>(bytes.data()), size)) throw refused("it can't be read to its end");
    return bytes;
  };
  Bytes head = first(std::min<std::streamoff>(end, kMagic.size()));
  const char* const start = reinterpret_cast<const char*>(head.data());
  const bool is_cell = std::equal(start, start + head.size, kMagic.begin());
  return is_cell ? first(end) : head;  // another file may be larger than the memory
}

}  // namespace

void end_without_value(const Error& error) noexcept {
  std::fprintf(stderr, "plannercheck: %s\n", error.message.c_str());
  std::abort();
}

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

}  // namespace

Workspace::Workspace() noexcept = default;
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

Checker::Checker(std::shared_ptr<const Impl> impl) noexcept : impl_(std::move(impl)) {}
Checker::Checker(const Checker&) noexcept = default;
Checker::Checker(Checker&& other) noexcept : impl_(other.impl_) {}  // a checker is never without a cell
Checker& Checker::operator=(const Checker&) noexcept = default;
Checker& Checker::operator=(Checker&& other) noexcept {
  impl_ = other.impl_;
  return *this;
}
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
      if (!impl_->cell->chained(table).touching.empty()) {  // at every state, so no motion is free
        for (const std::size_t row : rows) free[row] = 0;
        continue;
      }
      const double *some_starts = q0.data(), *some_ends = ends;
      if (rows.size() != n) {
        gather(q0.data(), width, rows, state.some_starts), gather(ends, width, rows, state.some_ends);
        some_starts = state.some_starts.data(), some_ends = state.some_ends.data();
      }
      state.answers.resize(rows.size());
      impl_->engine().check_motions(table, {some_starts, some_ends, width}, rows.size(), tolerance,
                                    state.answers.data(), *state.scratch);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto answer = static_cast<MotionAnswer>(state.answers[i]);
        check_precise(answer, "motion " + std::to_string(rows[i]), tolerance);
        free[rows[i]] = answer == MotionAnswer::kFree ? 1 : 0;
      }
    }
    return count_ones(free);
  });
}

Result<Verdict> Checker::explain(std::span<const double> q, Workspace& workspace, bool separations) const noexcept {
  return guarded<Verdict>([&] {
    impl_->check_width(q, 1);
    static_cast<void>(impl_->table_of(q.data(), 0));
    Workspace::State& state = state_of(workspace);
    Verdict verdict;
    const Engine::Explained found = impl_->engine().explain(q.data(), separations, *state.scratch);
    for (const auto& [row, point] : found.contacts)
      verdict.collisions.push_back({impl_->named(row), {point.x, point.y, point.z}});
    for (const auto& [row, plane] : found.apart) {
      Separation each{impl_->named(row), plane.has_value(), {}, 0, 0};
      if (plane) {
        each.normal = {plane->normal.x, plane->normal.y, plane->normal.z};
        each.offset = plane->offset, each.gap = plane->gap;
      }
      verdict.separations.push_back(std::move(each));
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
    const std::vector<std::int32_t>& touching = impl_->cell->chained(table).touching;
    if (!touching.empty()) return MotionVerdict{false, 0, -1, impl_->named(at(touching[0]))};
    const MotionReport report = impl_->engine().explain_motion(table, {q0.data(), end}, tolerance, *state.scratch);
    check_precise(report.answer, "motion 0", tolerance);
    if (report.answer == MotionAnswer::kFree) return MotionVerdict{};
    return MotionVerdict{false, report.free_until, report.refused, impl_->named(at(report.pair))};
  });
}

Result<std::vector<Distance>> Checker::distances(std::span<const double> q, Workspace& workspace, double limit,
                                                 std::size_t nearest) const noexcept {
  return guarded<std::vector<Distance>>([&] {
    const std::size_t width = impl_->width(), n = width == 0 ? 1 : q.size() / width;
    impl_->check_width(q, n);
    if (!(limit > 0)) throw CallError("limit must be positive, in m, not " + shown(limit));
    for (std::size_t i = 0; i < n; ++i) static_cast<void>(impl_->table_of(q.data() + i * width, i));
    Workspace::State& state = state_of(workspace);
    if (nearest > 0) limit = std::numeric_limits<double>::infinity();
    const DistanceTable table = impl_->engine().distances(q.data(), n, limit, nearest, *state.scratch);
    const std::size_t tangent = impl_->cell->tangent.width;
    const auto numbers = [](Vec3 v) { return std::array{v.x, v.y, v.z}; };
    std::vector<Distance> out;
    for (std::size_t k = 0; k < table.rows.size(); ++k) {
      const DistanceRow& row = table.rows[k];
      const auto gradient = table.gradients.begin() + static_cast<std::ptrdiff_t>(k * tangent);
      out.push_back({static_cast<std::size_t>(row.state),
                     impl_->named(at(row.pair)),
                     row.distance,
                     row.lower,
                     numbers(row.on_a),
                     numbers(row.on_b),
                     numbers(row.normal),
                     row.spread,
                     row.unique,
                     {gradient, gradient + static_cast<std::ptrdiff_t>(tangent)}});
    }
    return out;
  });
}

}  // namespace plannercheck
