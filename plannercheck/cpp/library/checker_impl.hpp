// What the face's sources share: a checker's engine, the checks of a call's inputs
// (plannercheck/robots/configurations.py has the same in Python), and the end of all exceptions, `guarded`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <plannercheck/checker.hpp>
#include <stdexcept>
#include <string>

#include "library/engine.hpp"
#include "library/nearest_turns.hpp"
#include "library/shown_values.hpp"

namespace plannercheck {

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

// Bytes at an address that doubles may have.
struct Bytes {
  std::vector<double> storage;
  std::size_t size;

  explicit Bytes(std::size_t count) : storage((count + sizeof(double) - 1) / sizeof(double)), size(count) {}
  std::byte* data() { return reinterpret_cast<std::byte*>(storage.data()); }
};

struct Workspace::State {
  std::shared_ptr<const void> of;  // the checker whose scratch it is
  std::unique_ptr<Engine::Scratch> scratch;
  std::vector<double> ends, some_starts, some_ends;
  std::array<std::vector<std::size_t>, 2> rows;  // by table
  std::vector<std::uint8_t> answers;
};

inline void check_tolerance(double tolerance) {
  if (tolerance > 0 && std::isfinite(tolerance)) return;
  throw CallError("tolerance must be a positive length in m, not " + shown(tolerance));
}

inline void check_precise(MotionAnswer answer, const std::string& what, double tolerance) {
  if (answer != MotionAnswer::kImprecise) return;
  throw CallError(what + ": lengths and angles are so large that rounding is no small part of the tolerance of " +
                  rounded(tolerance, 6) + " m; choose a larger tolerance, or smaller numbers");
}

[[noreturn]] inline void refuse_range(const PreparedCell& cell, const char* what, std::size_t row, std::size_t column) {
  throw CallError(what + (' ' + std::to_string(row)) + ": column " + std::to_string(column) + " leaves " +
                  listed(std::array{cell.usual_low[column], cell.usual_high[column]}) +
                  ", in which the cell's bound of rounding holds: take whole turns off, or check it in Python");
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
    const std::string nq = std::to_string(width()), size = std::to_string(q.size());
    if ((n != 1 || !q.empty()) && width() > 0 && q.size() % width() == 0)
      throw CallError(size + " numbers are " + std::to_string(q.size() / width()) + " configurations, not " +
                      std::to_string(n) + ": one for each answer");
    throw CallError("configurations must have shape (" + nq + ",) or (n, " + nq + "), not (" + size + ",); " +
                    cell->columns);
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

  // The pairs that judge a motion; its end as given, and `end` less whole turns.
  Table table_of_motion(const double* start, const double* given, const double* end, std::size_t row) const {
    bool within = true;
    for (const double* const q : {start, given, end})
      within &= table_of(q, row) == Table::kWithinLimits;  // all of them
    for (std::size_t k = 0; k < width(); ++k) {
      const double least = std::min({start[k], given[k], end[k]}), largest = std::max({start[k], given[k], end[k]});
      if (least < cell->usual_low[k] || largest > cell->usual_high[k]) refuse_range(*cell, "motion", row, k);
    }
    return within ? Table::kWithinLimits : Table::kAll;
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
    throw CallError("configurations must be finite (and at most " + rounded(cell->largest_value, 6) + "); row " +
                    std::to_string(row) + " is " + listed({q, width()}));
  }

  void check_unit(const double* q, std::size_t first, std::size_t past, std::size_t row) const {
    double square = 0;
    for (std::size_t k = first; k < past; ++k) square += q[k] * q[k];
    if (std::fabs(square - 1) <= cell->unit_tolerance) return;
    throw CallError("columns " + std::to_string(first) + " to " + std::to_string(past - 1) + " are " +
                    (past - first == 4 ? "a quaternion" : "cosine and sine") + ", of length 1; in row " +
                    std::to_string(row) + " it is " + shown(std::sqrt(square)) + ": normalise it in double precision");
  }
};

}  // namespace plannercheck
