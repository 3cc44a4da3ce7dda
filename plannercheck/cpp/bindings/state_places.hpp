// Where OMPL's bindings keep the numbers of states of a RealVectorStateSpace, which can then be read in place: a call
// of the space's `serialize` for each state would take a twenty-fifth of a search.
//
// In: states that nobody else uses, one of each kind: made in Python, or passed to Python by a planner. Out: the place
// of the numbers of other states of these kinds. Nothing documents where that is, so it is proved on the build at hand:
// for each kind, what is set through the bindings is read at the place, and what is written there is got through the
// bindings. Before that, memory is only read by the system, which says so where there is none.
//
// What is proved of one state holds for all of its kind. The bindings themselves find a state by its Python type and by
// the word that follows Python's header (nb_inst of nanobind): how far behind it a pointer lies, whether that is to be
// followed, whether the state is still there, and who frees it. C++ finds the numbers by the state's virtual table. A
// kind is all three. States of other kinds are read by `serialize`.
#pragma once

#include <nanobind/nanobind.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plannercheck {

class StatePlaces {
 public:
  // The numbers of a state; null if its kind has not been proved.
  const double* numbers_of(nanobind::handle state) const {
    if (!state.type().is(type_)) return nullptr;
    const Head& head = head_of(state);
    if (std::find(kinds_.begin(), kinds_.end(), head.word & kMeaning) == kinds_.end()) return nullptr;
    return head.state->table == table_ ? head.state->numbers : nullptr;
  }

  // Whether the numbers of states of this one's kind can be read in place from now on. It is overwritten.
  bool prove(nanobind::object state, std::size_t width) {
    Numbers inner;
    const nanobind::handle type = state.type();
    if (type_.is_valid() && !type.is(type_)) return false;
    if (reinterpret_cast<PyTypeObject*>(type.ptr())->tp_basicsize < static_cast<Py_ssize_t>(sizeof(Head))) return false;
    const Head& head = head_of(state);
    if (!copied(head.state, &inner, sizeof inner) || (type_.is_valid() && inner.table != table_)) return false;
    for (const double first : {0.7316, -5.0238}) {
      for (std::size_t k = 0; k < width; ++k) state[k] = first + static_cast<double>(k);
      std::vector<double> seen(width);
      if (!copied(inner.numbers, seen.data(), width * sizeof(double))) return false;
      for (std::size_t k = 0; k < width; ++k) {
        if (seen[k] != first + static_cast<double>(k)) return false;
      }
    }
    // Twice the memory there has followed what was set: it is the state's own.
    for (std::size_t k = 0; k < width; ++k) {
      inner.numbers[k] = 0.5 * static_cast<double>(k * k) - 1;
      if (nanobind::cast<double>(state[k]) != inner.numbers[k]) return false;
    }
    type_ = nanobind::borrow(type), table_ = inner.table;
    if (numbers_of(state) == nullptr) kinds_.push_back(head.word & kMeaning);
    return true;
  }

 private:
  // How a C++ object of this kind begins.
  struct Numbers {
    const void* table;
    double* numbers;
  };

  // How its Python object begins.
  struct Head {
    PyObject_HEAD std::uint64_t word;
    const Numbers* state;
  };

  // The bits of the word that say what is said above: 32 of the distance, 7 flags. Those that follow say whether other
  // objects are kept alive, or nothing: these are not even initialised.
  static constexpr std::uint64_t kMeaning = 0x7f'ffff'ffff;

  nanobind::object type_;
  const void* table_ = nullptr;
  std::vector<std::uint64_t> kinds_;

  static const Head& head_of(nanobind::handle state) { return *reinterpret_cast<const Head*>(state.ptr()); }

  // Copies memory, if there is any: where a program would crash, the system's calls fail.
  static bool copied(const void* from, void* to, std::size_t size) {
    std::array<int, 2> ends;
    if (::pipe(ends.data()) != 0) return false;
    const auto wanted = static_cast<ssize_t>(size);
    const bool done = ::write(ends[1], from, size) == wanted && ::read(ends[0], to, size) == wanted;
    ::close(ends[0]);
    ::close(ends[1]);
    return done;
  }
};

}  // namespace plannercheck
